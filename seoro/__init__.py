"""seoro runs OpenSCENARIO DSL scenarios against simulated and real robots.

The names below are its public interface. They are loaded when they are first used, so that `import seoro` costs
next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seoro.client import Client as Client
    from seoro.embed import Scenario as Scenario
    from seoro.embed import load as load
    from seoro.embed import replay as replay
    from seoro.embed import run as run
    from seoro.embed import start as start
    from seoro.embed.options import Lab as Lab
    from seoro.embed.options import Leasing as Leasing
    from seoro.embed.options import Ros as Ros
    from seoro.embed.options import Simulator as Simulator
    from seoro.embed.runs import Run as Run
    from seoro.embed.subscriptions import EventSubscription as EventSubscription
    from seoro.errors import ActionFailed as ActionFailed
    from seoro.errors import BackendError as BackendError
    from seoro.errors import InvalidScenario as InvalidScenario
    from seoro.errors import SeoroError as SeoroError
    from seoro.errors import SubscriptionOverflow as SubscriptionOverflow
    from seoro.errors import UsageError as UsageError
    from seoro.lang.plan.types import EnumValue as EnumValue
    from seoro.robotics.geometry import Orientation3D as Orientation3D
    from seoro.robotics.geometry import Pose3D as Pose3D
    from seoro.robotics.geometry import Position3D as Position3D
    from seoro.runtime.actions.context import ActionContext as ActionContext
    from seoro.runtime.actions.threads import ThreadContext as ThreadContext
    from seoro.runtime.contracts.modifiers import Child as Child
    from seoro.runtime.contracts.modifiers import ModifierContext as ModifierContext
    from seoro.runtime.events.occurrence import Occurrence as Occurrence
    from seoro.runtime.functions.actions import action as action
    from seoro.runtime.functions.modifiers import modifier as modifier
    from seoro.runtime.trace.reader import TraceReader as TraceReader
    from seoro.runtime.values.method_context import MethodContext as MethodContext
    from seoro.runtime.values.values import Actor as Actor
    from seoro.runtime.values.values import Range as Range
    from seoro.runtime.values.values import Struct as Struct
    from seoro.runtime.values.values import Variable as Variable
    from seoro.runtime.verdict import Outcome as Outcome
    from seoro.runtime.verdict import RunStatus as RunStatus
    from seoro.runtime.verdict import Status as Status
    from seoro.runtime.verdict import Verdict as Verdict

__version__ = "0.1.0"

# Modules of the public names.
_MODULES = {
    "seoro.client": ("Client",),
    "seoro.embed": ("Scenario", "load", "replay", "run", "start"),
    "seoro.embed.subscriptions": ("EventSubscription",),
    "seoro.embed.options": ("Lab", "Leasing", "Ros", "Simulator"),
    "seoro.embed.runs": ("Run",),
    "seoro.errors": (
        "ActionFailed",
        "BackendError",
        "InvalidScenario",
        "UsageError",
        "SeoroError",
        "SubscriptionOverflow",
    ),
    "seoro.lang.plan.types": ("EnumValue",),
    "seoro.runtime.actions.context": ("ActionContext",),
    "seoro.robotics.geometry": ("Orientation3D", "Pose3D", "Position3D"),
    "seoro.runtime.contracts.modifiers": ("Child", "ModifierContext"),
    "seoro.runtime.functions.actions": ("action",),
    "seoro.runtime.functions.modifiers": ("modifier",),
    "seoro.runtime.values.method_context": ("MethodContext",),
    "seoro.runtime.events.occurrence": ("Occurrence",),
    "seoro.runtime.trace.reader": ("TraceReader",),
    "seoro.runtime.actions.threads": ("ThreadContext",),
    "seoro.runtime.values.values": ("Actor", "Range", "Struct", "Variable"),
    "seoro.runtime.verdict": ("Outcome", "RunStatus", "Status", "Verdict"),
}

__all__ = sorted(name for names in _MODULES.values() for name in names)  # noqa: PLE0605


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


def __getattr__(name: str) -> Any:
    for module, names in _MODULES.items():
        if name in names:
            return getattr(import_module(module), name)
    raise AttributeError(f"module 'seoro' has no attribute {name!r}")

"""seoro runs OpenSCENARIO DSL scenarios against simulated and real robots.

The names below are its public interface. They are loaded when they are first used, so that `import seoro` costs
next to nothing.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from seoro.lazy_names import lazy_names

if TYPE_CHECKING:
    from seoro.client import Client
    from seoro.embed import Scenario, load, replay, run, start
    from seoro.embed.options import Lab, Leasing, Ros, Simulator
    from seoro.embed.runs import Run
    from seoro.embed.subscriptions import EventSubscription
    from seoro.errors import (
        ActionFailed,
        BackendError,
        InvalidScenario,
        SeoroError,
        SubscriptionOverflow,
        UsageError,
    )
    from seoro.lang.plan.types import EnumValue
    from seoro.robotics.geometry import Orientation3D, Pose3D, Position3D
    from seoro.runtime.actions.context import ActionContext
    from seoro.runtime.actions.threads import ThreadContext
    from seoro.runtime.contracts.modifiers import Child, ModifierContext
    from seoro.runtime.events.occurrence import Occurrence
    from seoro.runtime.functions.actions import action
    from seoro.runtime.functions.modifiers import modifier
    from seoro.runtime.trace.reader import TraceReader
    from seoro.runtime.values.environment import MethodContext
    from seoro.runtime.values.values import Actor, Range, Struct, Variable
    from seoro.runtime.verdict import Outcome, RunStatus, Status, Verdict

__version__ = "0.1.0"

__all__ = [
    "ActionContext",
    "ActionFailed",
    "Actor",
    "BackendError",
    "Child",
    "Client",
    "EnumValue",
    "EventSubscription",
    "InvalidScenario",
    "Lab",
    "Leasing",
    "MethodContext",
    "ModifierContext",
    "Occurrence",
    "Orientation3D",
    "Outcome",
    "Pose3D",
    "Position3D",
    "Range",
    "Ros",
    "Run",
    "RunStatus",
    "Scenario",
    "SeoroError",
    "Simulator",
    "Status",
    "Struct",
    "SubscriptionOverflow",
    "ThreadContext",
    "TraceReader",
    "UsageError",
    "Variable",
    "Verdict",
    "action",
    "load",
    "modifier",
    "replay",
    "run",
    "start",
]

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
    "seoro.runtime.values.environment": ("MethodContext",),
    "seoro.runtime.events.occurrence": ("Occurrence",),
    "seoro.runtime.trace.reader": ("TraceReader",),
    "seoro.runtime.actions.threads": ("ThreadContext",),
    "seoro.runtime.values.values": ("Actor", "Range", "Struct", "Variable"),
    "seoro.runtime.verdict": ("Outcome", "RunStatus", "Status", "Verdict"),
}


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


if not TYPE_CHECKING:  # type checkers report unknown names
    __getattr__ = lazy_names(__name__, _MODULES)

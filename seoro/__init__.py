"""seoro runs OpenSCENARIO DSL scenarios against simulated and real robots.

The names below are its public interface. They are loaded when they are first used, so that `import seoro` costs
next to nothing.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seoro.client import Client
    from seoro.embed import Scenario, load, run, start
    from seoro.embed.options import Lab, Leasing, Ros, Simulator
    from seoro.embed.runs import Run
    from seoro.errors import ActionFailed, BackendError, InvalidScenario, InvalidUse, SeoroError
    from seoro.lang.plan.types import EnumValue
    from seoro.runtime.actions import action
    from seoro.runtime.context import ActionContext
    from seoro.runtime.contracts import Child, ModifierContext, Orientation3D, Pose3D, Position3D
    from seoro.runtime.method_context import MethodContext
    from seoro.runtime.modifiers import modifier
    from seoro.runtime.reading import TraceReader
    from seoro.runtime.threads import ThreadContext
    from seoro.runtime.values import Actor, Range, Struct, Variable
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
    "InvalidScenario",
    "InvalidUse",
    "Lab",
    "Leasing",
    "MethodContext",
    "ModifierContext",
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
    "ThreadContext",
    "TraceReader",
    "Variable",
    "Verdict",
    "action",
    "load",
    "modifier",
    "run",
    "start",
]

_MODULES = {
    "seoro.client": ("Client",),
    "seoro.embed": ("Scenario", "load", "run", "start"),
    "seoro.embed.options": ("Lab", "Leasing", "Ros", "Simulator"),
    "seoro.embed.runs": ("Run",),
    "seoro.errors": ("ActionFailed", "BackendError", "InvalidScenario", "InvalidUse", "SeoroError"),
    "seoro.lang.plan.types": ("EnumValue",),
    "seoro.runtime.actions": ("action",),
    "seoro.runtime.context": ("ActionContext",),
    "seoro.runtime.contracts": ("Child", "ModifierContext", "Orientation3D", "Pose3D", "Position3D"),
    "seoro.runtime.method_context": ("MethodContext",),
    "seoro.runtime.modifiers": ("modifier",),
    "seoro.runtime.reading": ("TraceReader",),
    "seoro.runtime.threads": ("ThreadContext",),
    "seoro.runtime.values": ("Actor", "Range", "Struct", "Variable"),
    "seoro.runtime.verdict": ("Outcome", "RunStatus", "Status", "Verdict"),
}


def __dir__() -> list[str]:
    return [*__all__, "__version__"]


def __getattr__(name: str) -> Any:
    for module, names in _MODULES.items():
        if name in names:
            return getattr(import_module(module), name)
    raise AttributeError(f"module 'seoro' has no attribute {name!r}")

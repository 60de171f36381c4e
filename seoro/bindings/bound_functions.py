"""Python functions of a scenario."""

from __future__ import annotations

from dataclasses import field
from typing import TYPE_CHECKING

from seoro.lang.frozen import Value

if TYPE_CHECKING:
    from seoro.runtime.functions.actions import BoundAction
    from seoro.runtime.functions.modifiers import BoundModifier


class BoundFunctions(Value):
    """Functions that implement the actions and modifiers of a scenario and its libraries, by qualified names."""

    actions: dict[str, BoundAction] = field(default_factory=dict)
    modifiers: dict[str, BoundModifier] = field(default_factory=dict)

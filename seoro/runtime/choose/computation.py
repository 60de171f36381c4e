"""Computation of values without cells on access: equalities, ranges and lists."""

from __future__ import annotations

from dataclasses import replace
from typing import cast

from seoro.lang.plan import ListType
from seoro.runtime.choose.slots import Rule, Slot, Slots
from seoro.runtime.values.environment import Evaluate, EvaluationError
from seoro.runtime.values.fields import Compute
from seoro.runtime.values.values import Range, Value


class Computation:
    """Computes values without cells.

    Args:
        slots: The slots of the choice.
        evaluate: Evaluates expressions.
    """

    def __init__(self, slots: Slots, evaluate: Evaluate) -> None:
        self._slots = slots
        self._evaluate = evaluate
        self._open: set[int] = set()  # slots being computed, by identity
        self.is_final = False  # whether all cells have their values, so that results are kept

    def of(self, holder: object) -> Compute:
        """Return the function that computes missing fields of an instance."""
        slots = self._slots.of(holder)

        def compute(name: str) -> Value:
            return self._value(slots[name])

        return compute

    def _value(self, slot: Slot) -> Value:
        """Return the value of a slot without a cell; kept once all cells are final."""
        if slot.definition is not None:
            value = self._defined(slot, slot.definition)
        elif "lower" in slot.parts:
            low, high = (part.holder.fields[part.key] for part in slot.parts.values())
            value = Range(cast(float, low), cast(float, high))
        elif isinstance(slot.type, ListType):
            value = tuple(part.holder.fields[part.key] for part in slot.parts.values())
        else:
            raise KeyError(slot.key)
        if self.is_final:
            assign(slot, value)
        return value

    def _defined(self, slot: Slot, definition: Rule) -> Value:
        assert definition.value is not None
        if id(slot) in self._open:
            raise EvaluationError(f"the value of `{slot.path}` depends on itself", slot.span)
        self._open.add(id(slot))
        try:
            return self._evaluate(definition.value, replace(definition.environment, path=slot.path))
        finally:
            self._open.remove(id(slot))


def assign(slot: Slot, value: Value) -> None:
    """Put a value into the instance that holds it."""
    slot.holder.fields[slot.key] = value  # type: ignore[index] # all holders have a dict

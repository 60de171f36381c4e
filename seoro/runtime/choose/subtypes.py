"""Conditional subtypes (7.3.8.2.5) of values that are not chosen yet."""

from __future__ import annotations

from collections.abc import Callable

from seoro.lang.plan import ActorType, StructType, ValueType
from seoro.lang.solve import terms
from seoro.runtime.choose.forms import Symbolic, same
from seoro.runtime.choose.slots import Slots
from seoro.runtime.values.values import Actor, Struct


class Subtypes:
    """Computes the conditions of conditional subtypes.

    Args:
        slots: Slots of the choice.
        field: Returns a field of a value, as far as it is known.
    """

    def __init__(self, slots: Slots, field: Callable[[Symbolic, str], Symbolic]) -> None:
        self._slots = slots
        self._field = field

    def deciding_type(self, value: Symbolic, type_: ValueType) -> tuple[terms.Term, ...]:
        """Return the conditions for a value to be of a type; empty if decided."""
        if not isinstance(value, Struct | Actor) or not isinstance(type_, StructType | ActorType):
            return ()
        return self.deciding(value, type_.name)

    def deciding(self, value: Struct | Actor, name: str) -> tuple[terms.Term, ...]:
        """Return the conditions for a value to be of a named type; empty if decided."""
        slot = self._slots.holding(value)
        if slot is None or slot.structure is None:
            return ()
        latents = {latent.type: latent for latent in slot.structure.latents}
        conditions: list[terms.Term] = []
        while name in latents and name not in value.types:
            latent = latents[name]
            conditions.append(same(self._field(value, latent.field), latent.value))
            name = latent.base
        return tuple(conditions) if name in value.types else ()

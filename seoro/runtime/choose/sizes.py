"""Sizes of lists, as far as constraints mention them."""

from __future__ import annotations

from collections.abc import Iterable

from seoro.lang.plan import Index, Literal, Size, walk
from seoro.runtime.choose.slots import Rule, Slots


def mentions(rules: Iterable[Rule], slots: Slots) -> tuple[dict[int, int], set[int]]:
    """Return the mentioned numbers of members of lists, and the lists with mentioned sizes, by identity."""
    least: dict[int, int] = {}
    sized: set[int] = set()
    for rule in rules:
        for current in walk(rule.condition) if rule.condition is not None else ():
            match current:
                case Index(items, Literal(int(position))):
                    slot = slots.find(items, rule.environment)
                    if slot is not None:
                        least[id(slot)] = max(least.get(id(slot), 0), position + 1)
                case Size(items):
                    slot = slots.find(items, rule.environment)
                    if slot is not None:
                        sized.add(id(slot))
                case _:
                    pass
    return least, sized

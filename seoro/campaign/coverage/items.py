"""Definitions of the `cover` items of a scenario: names and buckets, and hashes to compare campaigns by."""

from __future__ import annotations

import hashlib
import math
from collections.abc import Iterable, Iterator, Mapping
from itertools import product
from typing import Final

from seoro.campaign.store.covered import CoveredItem
from seoro.lang import plan as plan_
from seoro.lang.plan import AnyCoverageItem, CoverageItem, CoverageKind, Plan
from seoro.runtime.coverage.buckets import buckets_with, labels_of
from seoro.runtime.instances.instances import types_of

MOST_BUCKETS: Final = 10_000  # of an item, that are listed
DIGITS: Final = 16  # hexadecimal, of a hash


def items_in(plan: Plan, types: Iterable[str]) -> Mapping[str, AnyCoverageItem]:
    """Return the `cover` items of a type and its bases, and all items that they combine, by name.

    Args:
        plan: The plan.
        types: Names of the type and its bases, as in `Plan.coverage`.
    """
    return {item.name: item for type_ in types for item in plan.coverage.get(type_, ())}


def covered_items(plan: Plan) -> tuple[CoveredItem, ...]:
    """Return the definitions of the `cover` items of all scenarios, actions and modifiers of a plan."""
    found: dict[str, CoveredItem] = {}
    reached: list[plan_.Scenario | plan_.Action | plan_.Modifier]
    reached = [*plan.scenarios.values(), *plan.actions.values(), *plan.modifiers.values()]
    for declared in reached:
        items = items_in(plan, types_of(declared))
        for item in items.values():
            name = f"{item.owner}.{item.name}"
            if item.kind is CoverageKind.COVER and name not in found:
                found[name] = _defined(name, item, items, plan)
    return tuple(found.values())


def parts_of(item: AnyCoverageItem, items: Mapping[str, AnyCoverageItem]) -> tuple[CoverageItem, ...]:
    """Return the items that an item combines; for others, the item itself."""
    if isinstance(item, CoverageItem):
        return (item,)
    parts = (items[name] for name in item.items)
    return tuple(part for part in parts if isinstance(part, CoverageItem))


def _defined(name: str, item: AnyCoverageItem, items: Mapping[str, AnyCoverageItem], plan: Plan) -> CoveredItem:
    parts = parts_of(item, items)
    labels = [labels_of(buckets_with(part, plan)) for part in parts]
    known = [each for each in labels if each is not None]
    is_listed = len(known) == len(labels) and math.prod(map(len, known)) <= MOST_BUCKETS
    unit = item.unit.name if isinstance(item, CoverageItem) and item.unit is not None else ""
    shape = "\n".join(line for part in parts for line in _shape(part))
    return CoveredItem(
        item=name,
        definition=hashlib.sha256(f"{item.target}\n{shape}".encode()).hexdigest()[:DIGITS],
        unit=unit,
        target=item.target,
        buckets=tuple(" x ".join(each) for each in product(*known)) if is_listed else None,
    )


def _shape(item: CoverageItem) -> Iterator[str]:
    """Yield all that determines the buckets and samples of an item."""
    yield f"{item.name} {item.event.name} {item.unit.name if item.unit is not None else ''} {item.it or ''}"
    yield repr(item.buckets)
    for expression in (item.expression, item.ignore, item.illegal):
        yield "" if expression is None else _text(expression)


def _text(expression: plan_.Expression) -> str:
    return " ".join(expression.span.text.split())

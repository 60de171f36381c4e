"""Bins of inputs: buckets of `cover` items over parameters, each with the constraints that lead to it."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace
from itertools import pairwise, product
from typing import Final

from seoro.campaign.coverage.inputs import Group
from seoro.campaign.coverage.items import MOST_BUCKETS, parts_of
from seoro.lang import plan as plan_
from seoro.lang.frozen import Value
from seoro.lang.plan import (
    UNIT_DIGITS,
    Buckets,
    CoverageItem,
    CoverageKind,
    CoverageUnit,
    EachValue,
    Edges,
    EnumValue,
    Levels,
    Plan,
)
from seoro.runtime.coverage.buckets import LEVELS, buckets_with, labels_of
from seoro.runtime.values.text import value_text

_HALF: Final = 0.49  # of the last digit
_LARGEST: Final = 1e15  # of bounds: those of a type lead nowhere


class Bin(Value):
    """Bucket of an input.

    Args:
        item: Qualified name of the item.
        bucket: Name of the bucket.
        target: Samples that it needs.
        parts: Number of combined items.
        ways: Constraints on parameters, as for `Options.constraints`. Those of any way lead to a sample there.
            Items of behaviors have a way for each invocation.
    """

    item: str
    bucket: str
    target: int
    parts: int
    ways: tuple[tuple[str, ...], ...]


def bins_of(groups: Iterable[Group], plan: Plan) -> tuple[Bin, ...]:
    """Return the bins of the `cover` items over parameters.

    Args:
        groups: Items of the entry scenario, and of behaviors that it invokes.
        plan: The plan.
    """
    found: dict[tuple[str, str], Bin] = {}
    for each in (each for group in groups for each in _bins(group, plan)):
        key = (each.item, each.bucket)
        found[key] = replace(each, ways=(*found[key].ways, *each.ways)) if key in found else each
    return tuple(found.values())


def _bins(group: Group, plan: Plan) -> Iterator[Bin]:
    for item in group.items.values():
        parts = parts_of(item, group.items)
        if (
            item.kind is not CoverageKind.COVER
            or not item.target
            or any(each.name not in group.texts for each in parts)
        ):
            continue
        choices = [_choices(each, group.texts[each.name], plan) for each in parts]
        if math.prod(map(len, choices)) > MOST_BUCKETS:
            continue
        for chosen in product(*choices):
            bucket = " x ".join(label for label, _ in chosen)
            constraints = tuple(constraint for _, constraint in chosen)
            yield Bin(f"{item.owner}.{item.name}", bucket, item.target, len(parts), (constraints,))


def _choices(item: CoverageItem, text: str, plan: Plan) -> list[tuple[str, str]]:
    """Return the buckets of an input, each with its constraint; none if they are unbounded.

    Args:
        item: The input.
        text: Its value as an expression.
        plan: The plan.
    """
    buckets = buckets_with(item, plan)
    labels = labels_of(buckets)
    if labels is None or len(labels) > MOST_BUCKETS or not _is_bounded(buckets):
        return []
    return list(zip(labels, _constraints(text, buckets, item.unit), strict=True))


def _is_bounded(buckets: Buckets) -> bool:
    return not isinstance(buckets, Levels) or max(abs(buckets.low), abs(buckets.high)) < _LARGEST


def _constraints(text: str, buckets: Buckets, unit: CoverageUnit | None) -> Iterator[str]:
    """Yield the constraint of each bucket, in order."""
    match buckets:
        case EachValue(values):
            for value in values:
                yield _equal(text, value, unit)
        case Edges(edges):
            for number, (low, high) in enumerate(pairwise(edges)):
                if low == high:
                    yield _equal(text, low, unit)
                else:
                    yield _between(text, low, high, unit, is_closed=number == len(edges) - 2)
        case Levels(low, high):
            yield _equal(text, low, unit)
            steps = [low + (high - low) * step / len(LEVELS) for step in range(len(LEVELS) + 1)]
            for number, (first, last) in enumerate(pairwise(steps)):
                above = ">" if number == 0 else ">="
                yield f"{text} {above} {_number(first, unit)} and {text} < {_number(last, unit)}"
            yield _equal(text, high, unit)
        case _:
            raise AssertionError("bounded")


def _equal(text: str, value: bool | int | float | str | EnumValue, unit: CoverageUnit | None) -> str:
    if unit is None or isinstance(value, str | EnumValue):
        return f"{text} == {_plain(value)}"
    if not value:
        return f"{text} == {_number(value, unit)}"
    # All values that are rounded to this one.
    width = _HALF * 10.0 ** (math.floor(math.log10(abs(value))) + 1 - UNIT_DIGITS)
    return f"{text} in [{_number(value - width, unit)}..{_number(value + width, unit)}]"


def _between(text: str, low: float, high: float, unit: CoverageUnit | None, *, is_closed: bool) -> str:
    limits = [
        f"{text} {relation} {_number(bound, unit)}"
        for relation, bound in ((">=", low), ("<=" if is_closed else "<", high))
        if math.isfinite(bound)
    ]
    return " and ".join(limits)


def _number(value: float, unit: CoverageUnit | None) -> str:
    return _plain(value) + (unit.name if unit is not None else "")


def _plain(value: bool | int | float | str | EnumValue) -> str:
    return value_text(value, None, plan_.Structures())

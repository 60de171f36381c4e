"""Bins of inputs: buckets of `cover` items over parameters, each with the constraints that lead to it.

An item is an input if the values chosen before the run determine it. All others are outputs, and only observed.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator
from itertools import pairwise, product
from typing import Final

from seoro.campaign.coverage.items import MOST_BUCKETS, items_in, parts_of
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
from seoro.runtime.instances.instances import types_of
from seoro.runtime.values.text import value_text

_HALF: Final = 0.49  # of the last digit
_LARGEST: Final = 1e15  # of bounds: those of a type lead nowhere
_PURE: Final = (
    plan_.Arithmetic, plan_.Bound, plan_.Compare, plan_.Conditional, plan_.Contains, plan_.Convert, plan_.Field,
    plan_.Global, plan_.Index, plan_.ListOf, plan_.Literal, plan_.Logic, plan_.Member, plan_.Negate, plan_.Not,
    plan_.RangeOf, plan_.Size,
)  # fmt: skip # expressions whose values parameters determine


class Bin(Value):
    """Bucket of an input.

    Args:
        item: Qualified name of the item.
        bucket: Name of the bucket.
        target: Samples that it needs.
        parts: Number of combined items.
        constraints: Constraints on parameters, as for `Options.constraints`; with them, samples are in the bucket.
    """

    item: str
    bucket: str
    target: int
    parts: int
    constraints: tuple[str, ...]


class Input(Value):
    """Item over parameters.

    Args:
        item: Its definition.
        text: Its value as an expression of the language, in the scope of the entry scenario.
    """

    item: CoverageItem
    text: str


def inputs_of(plan: Plan) -> dict[str, Input]:
    """Return the items of single values of the entry scenario that are inputs, by name."""
    entry = plan.scenarios[plan.entry]
    found: dict[str, Input] = {}
    for name, item in items_in(plan, types_of(entry)[::-1]).items():
        if isinstance(item, CoverageItem) and (text := _text_of(item, plan)) is not None:
            found[name] = Input(item, text)
    return found


def bins_of(plan: Plan) -> tuple[Bin, ...]:
    """Return the bins of the `cover` items over parameters of the entry scenario."""
    return tuple(_bins(plan))


def _bins(plan: Plan) -> Iterator[Bin]:
    items = items_in(plan, types_of(plan.scenarios[plan.entry])[::-1])
    inputs = inputs_of(plan)
    for item in items.values():
        parts = parts_of(item, items)
        if (
            item.kind is not CoverageKind.COVER
            or not item.target
            or any(each.name not in inputs for each in parts)
        ):
            continue
        choices = [_choices(inputs[each.name], plan) for each in parts]
        if math.prod(map(len, choices)) > MOST_BUCKETS:
            continue
        for chosen in product(*choices):
            bucket = " x ".join(label for label, _ in chosen)
            constraints = tuple(constraint for _, constraint in chosen)
            yield Bin(f"{item.owner}.{item.name}", bucket, item.target, len(parts), constraints)


def _choices(given: Input, plan: Plan) -> list[tuple[str, str]]:
    """Return the buckets of an input, each with its constraint; none if they are unbounded."""
    buckets = buckets_with(given.item, plan)
    labels = labels_of(buckets)
    if labels is None or len(labels) > MOST_BUCKETS or not _is_bounded(buckets):
        return []
    return list(zip(labels, _constraints(given.text, buckets, given.item.unit), strict=True))


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


def _text_of(item: CoverageItem, plan: Plan) -> str | None:
    """Return the value of an item as text, if parameters determine it; None otherwise."""
    for node in plan_.walk(item.expression):
        is_it = item.it is not None and isinstance(node, plan_.Binding) and node.name == "it"
        if not (isinstance(node, _PURE) or is_it):
            return None
        if isinstance(node, plan_.Field | plan_.Member) and _is_variable(node, item.it, plan):
            return None
    text = " ".join(item.expression.span.text.split())
    if item.it is not None:
        text = re.sub(r"\bit\b", item.it, text)
    return text if re.fullmatch(r"[\w.]+", text) else f"({text})"


def _is_variable(node: plan_.Field | plan_.Member, it: str | None, plan: Plan) -> bool:
    """Return whether a field is a variable, as far as its type is known."""
    fields = plan.scenarios[plan.entry].structure.fields
    first, *rest = (path_of(node, it) or "").split(".")
    if first not in fields:
        return False
    field = fields[first]
    for name in rest:
        if field.is_variable or not isinstance(field.type, plan_.StructType | plan_.ActorType):
            break
        structure = plan.structures.find(field.type)
        if structure is None or name not in structure.fields:
            break
        field = structure.fields[name]
    return field.is_variable


def path_of(node: plan_.Expression, it: str | None) -> str | None:
    """Return the path of a parameter; None for other expressions.

    Args:
        node: The expression.
        it: Field that `it` denotes; None if it is the instance.
    """
    match node:
        case plan_.Field(name) | plan_.Global(name):
            return name
        case plan_.Binding("it"):
            return it
        case plan_.Member(base, name):
            around = path_of(base, it)
            return None if around is None else f"{around}.{name}"
        case _:
            return None

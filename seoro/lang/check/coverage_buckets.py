"""Buckets of an item, from `range`, `every` and `buckets` (7.5.5), or from constraints and its type (7.5.7)."""

from __future__ import annotations

import math
import sys
from collections.abc import Callable, Mapping

from seoro.lang import plan
from seoro.lang.arithmetic import INT_LIMITS
from seoro.lang.check.coverage_arguments import BUCKET_ARGUMENTS, Argument, Literals
from seoro.lang.check.coverage_bounds import Bounds, is_a_number
from seoro.lang.check.plan_types import enum_value, type_name
from seoro.lang.diagnostic import Bag
from seoro.lang.diagnostics import coverage as messages
from seoro.lang.program import Program
from seoro.lang.symbols import Enumeration, Type
from seoro.lang.types import BOOL, INT, UINT, is_integer, is_number

MAX_BUCKETS = 10_000  # of an item
BYTE = 256  # ranges of integers up to this size have a bucket per value (7.5.7)
DIGITS = 12  # of edges, so that 0.1 + 0.2 is 0.3
_NO_BUCKETS = plan.Distinct()


def buckets_of(
    name: str,
    type_: Type,
    arguments: Mapping[str, Argument],
    literals: Literals,
    program: Program,
    bag: Bag,
    default: Callable[[], plan.Buckets],
) -> plan.Buckets:
    """Return the buckets of an item.

    Args:
        name: Its name.
        type_: Type of its scalar value.
        arguments: Its arguments.
        literals: Reader of the arguments.
        program: The program.
        bag: Bag for messages.
        default: Returns the buckets of an item without arguments for them.
    """
    given = [each for each in BUCKET_ARGUMENTS if each in arguments]
    if given and not is_number(type_):
        for each in given:
            bag.add(messages.no_buckets, arguments[each].place, each, name, type_name(type_, program))
        return _NO_BUCKETS
    if "buckets" in given:
        for each in given[:-1]:
            first, second = sorted((each, "buckets"), key=lambda name: arguments[name].place.start)
            reason = f"and `{first}` exclude each other"
            bag.add(messages.excluded_argument, arguments[second].place, second, reason, arguments[first].place)
        edges = literals.edges()
        return plan.Edges(edges) if edges is not None else _NO_BUCKETS
    bounds, width = literals.range(), literals.width()
    if bounds is not None and width is not None:
        if width == 1 and is_integer(type_) and bounds[1] - bounds[0] < MAX_BUCKETS:
            return _each(*bounds)
        return _sliced(bounds, width, arguments["every"], bag)
    if width is not None:
        return plan.Slices(width)
    return _of_range(bounds, is_integer(type_)) if bounds is not None else default()


def default_buckets(type_: Type, bounds: Bounds, unit: plan.CoverageUnit | None) -> plan.Buckets:
    """Return the buckets of an item without arguments for them: one for each listed value, else those of a range.

    Args:
        type_: Type of its scalar value.
        bounds: Values that constraints leave.
        unit: Its unit; None without one.
    """
    if bounds.left and len(bounds.left) <= MAX_BUCKETS:
        shown = (
            bounds.left
            if unit is None
            else tuple(unit.of_si(value) for value in bounds.left if is_a_number(value))
        )
        return plan.EachValue(tuple(dict.fromkeys(shown)))
    if is_number(type_) and math.isfinite(bounds.low) and math.isfinite(bounds.high) and bounds.low <= bounds.high:
        ends = (bounds.low, bounds.high) if unit is None else (unit.of_si(bounds.low), unit.of_si(bounds.high))
        return _of_range((min(ends), max(ends)), is_integer(type_))
    return _of_type(type_)


def _sliced(bounds: tuple[float, float], width: float, every: Argument, bag: Bag) -> plan.Buckets:
    """Divide a range into buckets; the last one is shorter if the width does not divide the range."""
    low, high = bounds
    quotient = _rounded((high - low) / width)
    if quotient > MAX_BUCKETS:
        bag.add(messages.too_many_buckets, every.value.span, MAX_BUCKETS)
        return _NO_BUCKETS
    count = max(1, math.ceil(quotient))
    return plan.Edges((*(_rounded(low + number * width) for number in range(count)), high))


def _of_range(bounds: tuple[float, float], is_whole: bool) -> plan.Buckets:
    """Return the buckets of a range without `every`."""
    low, high = bounds
    return _each(low, high) if is_whole and high - low < BYTE else plan.Levels(low, high)


def _each(low: float, high: float) -> plan.Buckets:
    return plan.EachValue(tuple(range(math.ceil(low), math.floor(high) + 1)))


def _of_type(type_: Type) -> plan.Buckets:
    """Return the buckets of all values of a type."""
    match type_:
        case Enumeration(symbol):
            values = [enum_value(symbol, member) for member in symbol.members]
            return plan.EachValue(tuple(dict.fromkeys(values)))
        case _ if type_ == BOOL:
            return plan.EachValue((False, True))
        case _ if type_ == INT:
            return plan.Levels(*INT_LIMITS)
        case _ if type_ == UINT:
            return plan.Levels(0, 2**64 - 1)
        case _ if is_number(type_):
            return plan.Levels(-sys.float_info.max, sys.float_info.max)
        case _:
            return _NO_BUCKETS


def _rounded(value: float) -> float:
    """Round to `DIGITS` digits; exact integers stay unchanged."""
    return value if isinstance(value, int) else float(f"{value:.{DIGITS}g}")

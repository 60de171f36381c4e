"""Timing arguments of behaviors, and timing of the members of `parallel` (7.3.13.2, 7.6.2.1.4).

Times of members are relative to the first member, the primary one.

An offset is the start or end of a secondary member minus that of the primary one [s]. The kind of overlap and the
arguments `start_to_start` and `end_to_end` bound offsets. If that leaves a choice, all members start together; an
offset in a given range is drawn from the seed, for each secondary member.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from random import Random
from typing import Final

from seoro.lang.frozen import Value
from seoro.lang.plan import EnumValue, InvokeAction, InvokeScenario, OneOf, Overlap, Parallel, Serial
from seoro.lang.source import Span
from seoro.runtime.execution.context import ExecutionContext
from seoro.runtime.expressions.evaluation import evaluate
from seoro.runtime.instances.times import DURATION, END_TO_END, OVERLAP, START_TO_START, Times, Window
from seoro.runtime.values.environment import Environment, EvaluationError
from seoro.runtime.values.values import Range


def times_of(plan: Serial | Parallel | OneOf | InvokeScenario | InvokeAction, environment: Environment) -> Times:
    """Evaluate the timing arguments of a behavior.

    Raises:
        EvaluationError: An argument has no value, or a duration is negative.
    """
    if plan.duration is None and not isinstance(plan, Parallel):
        return Times(plan.span, {})
    arguments = {DURATION: plan.duration}
    if isinstance(plan, Parallel):
        arguments |= {START_TO_START: plan.start_to_start, END_TO_END: plan.end_to_end}
    given: dict[str, tuple[Range, Span]] = {}
    for name, argument in arguments.items():
        if argument is not None:
            bounds = evaluate(argument, environment)
            assert isinstance(bounds, Range), "checked: a single time becomes a range"
            if name == DURATION:
                check_duration(bounds, argument.span)
            given[name] = bounds, argument.span
    if isinstance(plan, Parallel):
        return Times(plan.span, given, plan.overlap, plan.is_overlap_given)
    return Times(plan.span, given)


def check_duration(duration: Range, span: Span) -> None:
    """Check the bounds of a duration [s].

    Raises:
        EvaluationError: A bound is negative.
    """
    if duration.low < 0:
        raise EvaluationError(f"invalid duration: expected at least 0 s, found {duration.low:g} s", span)


_ANY: Final = Range(-inf, inf)
_SAME: Final = Range(0.0, 0.0)
_BEFORE: Final = Range(-inf, 0.0)
_AFTER: Final = Range(0.0, inf)
_ALLOWED: Final[Mapping[Overlap, tuple[Range, Range]]] = {  # offsets of starts and of ends
    Overlap.EQUAL: (_SAME, _SAME),
    Overlap.START: (_SAME, _ANY),
    Overlap.END: (_ANY, _SAME),
    Overlap.INITIAL: (_BEFORE, _ANY),
    Overlap.FINAL: (_ANY, _AFTER),
    Overlap.INSIDE: (_AFTER, _BEFORE),
    Overlap.FULL: (_BEFORE, _AFTER),
    Overlap.ANY: (_ANY, _ANY),
}


class Timing(Value):
    """Times at which members start and end.

    Args:
        starts: Start of each member after the start of the composition [s]; the smallest is 0.
        ends: Permitted offsets of secondary members at their ends [s].
        cuts: Offset at which each secondary member is ended if it is open-ended [s]; infinite for never.
    """

    starts: tuple[float, ...]
    ends: Range
    cuts: tuple[float, ...]


def timing_of(plan: Parallel, context: ExecutionContext) -> Timing:
    """Return the timing of the members of a composition.

    Raises:
        EvaluationError: An offset has no value, or contradicts the kind of overlap.
    """
    secondaries = len(plan.members) - 1
    overlap, windows = _overlap_of(plan, context)
    allowed_starts, ends = _ALLOWED[overlap]
    if not windows and ends.high == inf:  # the usual case; nothing is drawn
        return Timing((0.0,) * (secondaries + 1), ends, (inf,) * (secondaries + 1))
    random = context.services.random(f"{context.purpose()} offsets")
    offsets = [0.0] * (secondaries + 1)
    if START_TO_START in windows:
        starts = _bounds(windows[START_TO_START], allowed_starts, overlap)
        offsets[1:] = [_offset(starts, windows[START_TO_START], random) for _ in range(secondaries)]
    first = min(offsets)
    if END_TO_END in windows:
        ends = _bounds(windows[END_TO_END], ends, overlap)
    last = Range(max(ends.low, 0.0), max(ends.high, 0.0))
    cuts = [inf] * secondaries if last.high == inf else [_draw(last, random) for _ in range(secondaries)]
    return Timing(tuple(offset - first for offset in offsets), ends, (inf, *cuts))


def _overlap_of(plan: Parallel, context: ExecutionContext) -> tuple[Overlap, Mapping[str, Window]]:
    """Return the kind of overlap, and the windows of offsets, from arguments and constraints."""
    if context.invoked is None:
        return plan.overlap, times_of(plan, context.environment()).plain()[1]
    composed = context.invoked.instance
    chosen = composed.fields[OVERLAP]
    assert isinstance(chosen, EnumValue)
    return Overlap(chosen.member), composed.windows


def _bounds(window: Window, allowed: Range, overlap: Overlap) -> Range:
    """Return the part of a window that the kind of overlap allows."""
    given = window.bounds
    low, high = max(given.low, allowed.low), min(given.high, allowed.high)
    if low > high:
        shown = f"{given.low:g} s" if given.low == given.high else f"[{given.low:g}..{given.high:g}] s"
        raise EvaluationError(f"an offset of {shown} contradicts `overlap: {overlap.value}`", window.span)
    return Range(low, high)


def _offset(bounds: Range, window: Window, random: Random) -> float:
    """Return an offset of starts; without bounds, members start as close together as possible."""
    if bounds.low == -inf or bounds.high == inf:
        offset = min(max(0.0, bounds.low), bounds.high)
    else:
        offset = _draw(bounds, random)
    return offset if window.fits(offset) else window.value


def _draw(bounds: Range, random: Random) -> float:
    return bounds.low if bounds.low == bounds.high else random.uniform(bounds.low, bounds.high)

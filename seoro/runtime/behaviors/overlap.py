"""How members of `parallel` lie to its first, the primary one (7.3.13.2, 7.6.2.1.4).

An offset is how much later a secondary member starts or ends than the primary one [s]. Kinds of overlap and the
arguments `start_to_start` and `end_to_end` bound offsets. Where that leaves a choice, all members start together,
and an offset from a range that is given is drawn from the seed, for each secondary member.
"""

from __future__ import annotations

from collections.abc import Mapping
from math import inf
from random import Random
from typing import Final

from seoro.lang.frozen import Value
from seoro.lang.plan import EnumValue, Overlap, Parallel
from seoro.runtime.behaviors.duration import times_of
from seoro.runtime.choose.times import END_TO_END, OVERLAP, START_TO_START, Window
from seoro.runtime.evaluate import EvaluationError
from seoro.runtime.place import Place
from seoro.runtime.values import Range

_ANY: Final = Range(-inf, inf)
_STARTS: Final[Mapping[Overlap, Range]] = {
    Overlap.EQUAL: Range(0.0, 0.0),
    Overlap.START: Range(0.0, 0.0),
    Overlap.END: _ANY,
    Overlap.INITIAL: Range(-inf, 0.0),
    Overlap.FINAL: _ANY,
    Overlap.INSIDE: Range(0.0, inf),
    Overlap.FULL: Range(-inf, 0.0),
    Overlap.ANY: _ANY,
}
_ENDS: Final[Mapping[Overlap, Range]] = {
    Overlap.EQUAL: Range(0.0, 0.0),
    Overlap.START: _ANY,
    Overlap.END: Range(0.0, 0.0),
    Overlap.INITIAL: _ANY,
    Overlap.FINAL: Range(0.0, inf),
    Overlap.INSIDE: Range(-inf, 0.0),
    Overlap.FULL: Range(0.0, inf),
    Overlap.ANY: _ANY,
}


class Timing(Value):
    """When members start and end.

    Args:
        starts: How long after the start of the composition each member starts [s]; one starts at once.
        ends: The offsets that secondary members may have at their ends [s].
        cuts: The offset at which each secondary member is ended if it is open-ended [s]; it is infinite if nothing
            ends it.
    """

    starts: tuple[float, ...]
    ends: Range
    cuts: tuple[float, ...]


def timing_of(plan: Parallel, place: Place) -> Timing:
    """When the members of a composition start and end.

    Raises:
        EvaluationError: An offset has no value, or the kind of overlap excludes it.
    """
    secondaries = len(plan.members) - 1
    random = place.services.random(f"{place.purpose} offsets")
    overlap, windows = _overlap_of(plan, place)
    offsets = [0.0] * (secondaries + 1)
    if START_TO_START in windows:
        starts = _bounds(windows[START_TO_START], _STARTS[overlap], overlap)
        offsets[1:] = [_offset(starts, windows[START_TO_START], random) for _ in range(secondaries)]
    first = min(offsets)
    ends = _ENDS[overlap]
    if END_TO_END in windows:
        ends = _bounds(windows[END_TO_END], ends, overlap)
    last = Range(max(ends.low, 0.0), max(ends.high, 0.0))
    cuts = [inf] * secondaries if last.high == inf else [_draw(last, random) for _ in range(secondaries)]
    return Timing(tuple(offset - first for offset in offsets), ends, (inf, *cuts))


def _overlap_of(plan: Parallel, place: Place) -> tuple[Overlap, Mapping[str, Window]]:
    """The kind of overlap, and what is said about offsets, by arguments and constraints."""
    if place.invoked is None:
        return plan.overlap, times_of(plan, place.environment()).plain()[1]
    composed = place.invoked.instance
    chosen = composed.fields[OVERLAP]
    assert isinstance(chosen, EnumValue)
    return Overlap(chosen.member), composed.windows


def _bounds(window: Window, allowed: Range, overlap: Overlap) -> Range:
    """What is left of the offsets of a window."""
    given = window.bounds
    low, high = max(given.low, allowed.low), min(given.high, allowed.high)
    if low > high:
        shown = f"{given.low:g} s" if given.low == given.high else f"[{given.low:g}..{given.high:g}] s"
        raise EvaluationError(f"an offset of {shown} is excluded by `overlap: {overlap.value}`", window.span)
    return Range(low, high)


def _offset(bounds: Range, window: Window, random: Random) -> float:
    """An offset of starts; where nothing bounds it, members start as close to each other as they can."""
    if bounds.low == -inf or bounds.high == inf:
        offset = min(max(0.0, bounds.low), bounds.high)
    else:
        offset = _draw(bounds, random)
    return offset if window.fits(offset) else window.value


def _draw(bounds: Range, random: Random) -> float:
    return bounds.low if bounds.low == bounds.high else random.uniform(bounds.low, bounds.high)

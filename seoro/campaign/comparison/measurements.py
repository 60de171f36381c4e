"""Changes of measurements between pairs of runs that passed in both campaigns."""

from __future__ import annotations

import math
from array import array
from dataclasses import replace
from itertools import groupby
from statistics import median

from seoro.campaign.comparison.pairs import Joined
from seoro.campaign.runs import End
from seoro.campaign.statistics.comparison import adjust, mcnemar, median_change
from seoro.campaign.statistics.rates import Bounds
from seoro.lang.frozen import Value


class MeasurementChange(Value):
    """Change of one measurement.

    Args:
        name: Column of `runs.csv`.
        variants: Number of variants, whose repeats count as one; of pairs, if nothing varies.
        before: Median over variants in the first campaign.
        after: Median over variants in the second one.
        change: Median change of a variant.
        bounds: 95 % interval of `change`.
        rising: Number of variants with a larger value than before.
        falling: Number of variants with a smaller one.
        p: P-value of the sign test, adjusted for all measurements by the method of Holm.
    """

    name: str
    variants: int
    before: float
    after: float
    change: float
    bounds: Bounds
    rising: int
    falling: int
    p: float

    @property
    def is_significant(self) -> bool:
        """Whether the change is significant at 5 %."""
        return self.p <= 0.05


def measurement_changes(joined: Joined) -> tuple[MeasurementChange, ...]:
    """Return the changes of all measurements, the most significant first.

    Args:
        joined: The campaigns. Failures end runs early, so pairs count if both runs passed.
    """
    passed = joined.select(lambda first, second: first is second is End.PASSED).positions
    is_varied = any(joined.variants[each] != joined.variants[passed[0]] for each in passed)
    groups = joined.variants if is_varied else joined.seeds
    order = array("q", sorted(passed, key=groups.__getitem__))
    first, second = joined.numbers
    changes = (_change(name, joined, order, groups) for name in second if name in first)
    found = [each for each in changes if each is not None]
    adjusted = adjust([each.p for each in found])
    return tuple(
        sorted(
            (replace(each, p=p) for each, p in zip(found, adjusted, strict=True)),
            key=lambda each: (each.p, each.name),
        )
    )


def _change(name: str, joined: Joined, order: array[int], groups: array[int]) -> MeasurementChange | None:
    """Return the change of a measurement; None if no pair has it in both campaigns.

    Args:
        name: The measurement.
        joined: The campaigns.
        order: Positions of the pairs, those of a group together.
        groups: The group of each pair, whose values count as one.
    """
    (first, second), places = (each[name] for each in joined.numbers), joined.places
    firsts, seconds, changes = array("d"), array("d"), array("d")
    for _, group in groupby(order, groups.__getitem__):
        values = [(first[places[each]], second[each]) for each in group]
        values = [(before, after) for before, after in values if not math.isnan(before + after)]
        if values:
            firsts.append(median(before for before, _ in values))
            seconds.append(median(after for _, after in values))
            changes.append(median(after - before for before, after in values))
    if not changes:
        return None
    rising, falling = sum(each > 0.0 for each in changes), sum(each < 0.0 for each in changes)
    return MeasurementChange(
        name,
        len(changes),
        median(firsts),
        median(seconds),
        median(changes),
        median_change(changes),
        rising,
        falling,
        mcnemar(rising, falling),  # a sign test, too
    )

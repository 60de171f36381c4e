"""Changes of measurements between pairs of runs that passed in both campaigns."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from statistics import median

from seoro.campaign.comparison.pairs import Pair
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


def measurement_changes(pairs: Sequence[Pair]) -> tuple[MeasurementChange, ...]:
    """Return the changes of all measurements, the most significant first.

    Args:
        pairs: Pairs of runs. Failures end runs early, so pairs count if both runs passed.
    """
    passed = [pair for pair in pairs if pair.before.end is pair.after.end is End.PASSED]
    names = dict.fromkeys(name for pair in passed for name in pair.after.numbers if name in pair.before.numbers)
    found = [_change(name, passed) for name in names]
    adjusted = adjust([each.p for each in found])
    changes = [replace(each, p=p) for each, p in zip(found, adjusted, strict=True)]
    return tuple(sorted(changes, key=lambda each: (each.p, each.name)))


def _change(name: str, pairs: Sequence[Pair]) -> MeasurementChange:
    by_variant: dict[str | int, list[tuple[float, float]]] = {}
    is_varied = len({pair.variant for pair in pairs}) > 1
    for pair in pairs:
        before, after = pair.before.numbers.get(name), pair.after.numbers.get(name)
        if before is not None and after is not None:
            by_variant.setdefault(pair.variant if is_varied else pair.seed, []).append((before, after))
    firsts = [median(before for before, _ in values) for values in by_variant.values()]
    seconds = [median(after for _, after in values) for values in by_variant.values()]
    changes = [median(after - before for before, after in values) for values in by_variant.values()]
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

"""Paired comparison, against SciPy and by planted differences."""

from random import Random
from statistics import median

import pytest
from scipy.stats import binom, binomtest, fisher_exact

from seoro.campaign.statistics.comparison import adjust, mcnemar, median_change
from seoro.campaign.statistics.drops import fisher, paired_drop_bound, unpaired_drop_bound
from seoro.campaign.statistics.rates import Bounds


@pytest.mark.parametrize(
    ("failing", "passing"), [(0, 0), (1, 0), (5, 0), (6, 0), (9, 2), (4, 4), (40, 20), (3000, 2800)]
)
def test_mcnemar_agrees_with_scipy(failing: int, passing: int) -> None:
    expected = binomtest(failing, failing + passing).pvalue if failing + passing else 1.0
    assert mcnemar(failing, passing) == pytest.approx(expected, rel=1e-8)
    assert mcnemar(passing, failing) == mcnemar(failing, passing)


def test_300_pairs_find_a_regression_of_3_percent() -> None:
    random = Random(11)
    found = alarms = 0
    for _ in range(400):
        found += mcnemar(sum(random.random() < 0.03 for _ in range(300)), 0) <= 0.05
        changed = sum(random.random() < 0.03 for _ in range(300))
        failing = sum(random.random() < 0.5 for _ in range(changed))
        alarms += mcnemar(failing, changed - failing) <= 0.05
    assert found >= 0.8 * 400
    assert alarms <= 0.05 * 400


def test_holm_adjusts_for_several_tests() -> None:
    assert adjust([0.01, 0.04, 0.03, 0.005]) == pytest.approx((0.03, 0.06, 0.06, 0.02))
    assert adjust([0.9, 0.6]) == (1.0, 1.0)
    assert adjust([]) == ()


def test_the_median_change_has_an_interval() -> None:
    random = Random(2)
    changes = [random.gauss(0.5, 1.0) for _ in range(200)]
    found = median_change(changes)
    medians = sorted(median(random.choices(changes, k=200)) for _ in range(2000))
    assert found.low == pytest.approx(medians[50], abs=0.02)
    assert found.high == pytest.approx(medians[-51], abs=0.02)
    assert median_change([0.25]) == Bounds(0.25, 0.25)
    assert median_change([0.0, 0.0, 5.0]) == Bounds(0.0, 5.0)


def test_the_interval_of_the_median_change_contains_it() -> None:
    random = Random(4)
    contained = 0
    for _ in range(400):
        found = median_change([random.expovariate(1.0) for _ in range(30)])
        contained += found.low <= 0.6931 <= found.high
    assert contained >= 0.93 * 400


@pytest.mark.parametrize("passing", [0.0, 0.01])
def test_a_drop_of_the_margin_is_rarely_called_smaller(passing: float) -> None:
    pairs, margin = 300, 0.02
    failing = passing + margin
    wrong = 0.0
    for changed in range(40):
        chances = binom.pmf(range(changed + 1), changed, passing / (failing + passing))
        chance = binom.pmf(changed, pairs, failing + passing)
        for fewer in range(changed + 1):
            is_called = paired_drop_bound(changed - fewer, fewer, pairs) < margin
            wrong += is_called * chance * chances[fewer]
    assert wrong <= 0.061, "nominally 5 %"


def test_bounds_of_the_drop() -> None:
    assert paired_drop_bound(0, 0, 300) == pytest.approx(0.0089, abs=1e-4)
    assert paired_drop_bound(9, 0, 300) > 0.045 and paired_drop_bound(0, 9, 300) < 0.0
    assert paired_drop_bound(2, 0, 300) < 0.02 < paired_drop_bound(4, 0, 300)
    assert paired_drop_bound(5, 0, 5) == pytest.approx(1.0, abs=1e-6)
    assert unpaired_drop_bound((950, 1000), (950, 1000)) == pytest.approx(0.0164, abs=1e-3)
    assert unpaired_drop_bound((100, 100), (50, 100)) > 0.5


@pytest.mark.parametrize(
    "counts", [((9, 10), (3, 10)), ((50, 50), (50, 50)), ((970, 1000), (930, 1000)), ((0, 3), (2, 2))]
)
def test_fishers_test_agrees_with_scipy(counts: tuple[tuple[int, int], tuple[int, int]]) -> None:
    (passed, runs), (others, total) = counts
    expected = fisher_exact([[passed, runs - passed], [others, total - others]]).pvalue
    assert fisher(*counts) == pytest.approx(expected, rel=1e-6)

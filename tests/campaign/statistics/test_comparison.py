"""Paired comparison, against SciPy and by planted differences."""

from random import Random

import pytest
from scipy.stats import binomtest

from seoro.campaign.statistics.comparison import adjust, mcnemar, median_change


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
    found = median_change(changes, seed=1)
    assert 0.2 < found.low < 0.5 < found.high < 0.8
    assert median_change(changes, seed=1) == found
    assert median_change([0.25], seed=1).low == 0.25


def test_the_interval_of_the_median_change_contains_it() -> None:
    random = Random(4)
    contained = 0
    for seed in range(20):
        found = median_change([random.expovariate(1.0) for _ in range(30)], seed)
        contained += found.low <= 0.6931 <= found.high
    assert contained >= 17

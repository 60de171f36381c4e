"""Bounds of rates, against SciPy and against exact probabilities."""

import math
from itertools import product
from random import Random

import pytest
from scipy.special import betainc, betaincinv
from scipy.stats import binomtest

from seoro.campaign.statistics.beta import beta_cdf, beta_quantile
from seoro.campaign.statistics.rates import Bounds, fixed_bounds, live_bounds
from tests.campaign.statistics.exact import probability_of_exclusion


@pytest.mark.parametrize("a", [0.5, 1, 7, 300, 99_000])
@pytest.mark.parametrize("b", [1, 2.5, 40, 1_000_000])
def test_beta_agrees_with_scipy(a: float, b: float) -> None:
    mean = a / (a + b)
    for x in (0.0, 0.3 * mean, mean, min(1.2 * mean, 1.0), 0.9, 1.0):
        assert beta_cdf(x, a, b) == pytest.approx(float(betainc(a, b, x)), rel=1e-8, abs=1e-200)
    for share in (0.025, 0.5):
        assert beta_quantile(share, a, b) == pytest.approx(float(betaincinv(a, b, share)), rel=1e-8)


@pytest.mark.parametrize(
    ("successes", "runs"), [(0, 1), (1, 1), (0, 59), (59, 59), (3, 10), (97, 100), (999, 1000)]
)
@pytest.mark.parametrize("confidence", [0.95, 0.99])
def test_fixed_bounds_agree_with_scipy(successes: int, runs: int, confidence: float) -> None:
    expected = binomtest(successes, runs).proportion_ci(confidence, method="exact")
    found = fixed_bounds(successes, runs, confidence)
    assert (found.low, found.high) == pytest.approx((expected.low, expected.high), abs=1e-9)


@pytest.mark.parametrize(("runs", "rate"), [(20, 0.9), (60, 0.97), (120, 0.5)])
def test_fixed_bounds_cover_the_rate(runs: int, rate: float) -> None:
    chance = 0.0
    for passed in range(runs + 1):
        found = fixed_bounds(passed, runs)
        if found.low <= rate <= found.high:
            chance += math.comb(runs, passed) * rate**passed * (1.0 - rate) ** (runs - passed)
    assert 0.95 <= chance < 1.0


def test_live_bounds_are_where_the_mixture_is_twenty_times_as_likely() -> None:
    found = live_bounds(90, 100)
    mixture = 1.0 / (101 * math.comb(100, 90))
    for rate in (found.low, found.high):
        assert mixture / (rate**90 * (1.0 - rate) ** 10) == pytest.approx(20.0, rel=1e-6)
    assert 0.77 < found.low < 0.9 < found.high < 0.98


def test_live_bounds_are_symmetric_and_narrow_down() -> None:
    assert live_bounds(0, 0) == Bounds(0.0, 1.0)
    for successes, runs in product((0, 1, 5, 10), (10, 1000, 1_000_000)):
        found, mirrored = live_bounds(successes, runs), live_bounds(runs - successes, runs)
        assert (found.low, found.high) == pytest.approx((1.0 - mirrored.high, 1.0 - mirrored.low), abs=1e-12)
        assert found.low <= successes / runs <= found.high
    widths = [found.high - found.low for found in (live_bounds(9 * n, 10 * n) for n in (1, 10, 100, 1000))]
    assert widths == sorted(widths, reverse=True)


@pytest.mark.parametrize("rate", [0.5, 0.9, 0.97])
def test_live_bounds_exclude_the_rate_at_no_time_in_95_percent(rate: float) -> None:
    assert 0.005 < probability_of_exclusion(live_bounds, rate, 1000) <= 0.05


def test_fixed_bounds_exclude_the_rate_at_some_time_far_more_often() -> None:
    assert probability_of_exclusion(fixed_bounds, 0.9, 100) > 0.15


@pytest.mark.slow
def test_live_bounds_in_a_thousand_campaigns() -> None:
    random = Random(7)
    wrong = 0
    for _ in range(1000):
        rate, passed = random.choice([0.5, 0.9, 0.97]), 0
        for runs in range(1, 2001):
            passed += random.random() < rate
            found = live_bounds(passed, runs)
            if not found.low <= rate <= found.high:
                wrong += 1
                break
    assert wrong <= 50


@pytest.mark.parametrize(
    ("successes", "runs", "confidence"), [(-1, 3, 0.95), (4, 3, 0.95), (1, 3, 1.0), (1, 3, 0.0)]
)
def test_numbers_that_are_not_a_rate(successes: int, runs: int, confidence: float) -> None:
    for bounds in (fixed_bounds, live_bounds):
        with pytest.raises(ValueError, match="expected"):
            bounds(successes, runs, confidence)

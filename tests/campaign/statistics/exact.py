"""Exact probabilities of campaigns whose runs pass independently with a known rate."""

from collections.abc import Callable

from seoro.campaign.statistics.rates import Bounds
from seoro.campaign.statistics.sequential_test import Decision, SequentialTest

BoundsOf = Callable[[int, int], Bounds]


def probability_of_exclusion(bounds_of: BoundsOf, rate: float, runs: int) -> float:
    """Probability that bounds exclude the rate after any of the first runs.

    Args:
        bounds_of: Bounds for a number of successes and of runs.
        rate: True rate.
        runs: Number of runs.
    """
    chances = {0: 1.0}  # of each number of failures, without exclusion so far
    excluded = 0.0
    least = most = 0  # numbers of failures without exclusion; both grow by at most 1 per run
    for number in range(1, runs + 1):
        grown: dict[int, float] = {}
        for failures, chance in chances.items():
            grown[failures] = grown.get(failures, 0.0) + chance * rate
            grown[failures + 1] = grown.get(failures + 1, 0.0) + chance * (1.0 - rate)
        while bounds_of(number - least, number).low > rate:
            least += 1
        if most < number and bounds_of(number - most - 1, number).high >= rate:
            most += 1
        excluded += sum(chance for failures, chance in grown.items() if not least <= failures <= most)
        chances = {failures: chance for failures, chance in grown.items() if least <= failures <= most}
    return excluded


def decisions(test: SequentialTest, rate: float) -> tuple[float, float]:
    """Return the probability that a test decides for the good rate, and its mean number of runs."""
    chances = {0: 1.0}  # of each number of failures, while the test is open
    good = mean = 0.0
    number = 0
    while (rest := sum(chances.values())) > 1e-9:
        mean += rest
        number += 1
        grown: dict[int, float] = {}
        for failures, chance in chances.items():
            grown[failures] = grown.get(failures, 0.0) + chance * rate
            grown[failures + 1] = grown.get(failures + 1, 0.0) + chance * (1.0 - rate)
        decided = {failures: test.decide(number - failures, failures) for failures in grown}
        good += sum(grown[failures] for failures, each in decided.items() if each is Decision.GOOD)
        chances = {failures: grown[failures] for failures, each in decided.items() if each is Decision.OPEN}
    return good, mean

"""Sequential test, by the exact probabilities of its decisions."""

import pytest

from seoro.campaign.statistics.sequential_test import Decision, SequentialTest
from tests.campaign.statistics.exact import decisions

TEST = SequentialTest(good=0.97, bad=0.90)


@pytest.mark.parametrize(
    "test",
    [
        TEST,
        SequentialTest(0.95, 0.90),
        SequentialTest(0.99, 0.95, errors=0.01),
        SequentialTest(0.6, 0.5, errors=0.1),
    ],
)
def test_decisions_are_wrong_at_most_as_often_as_promised(test: SequentialTest) -> None:
    accepted, _ = decisions(test, test.good)
    assert 1.0 - test.errors <= accepted < 1.0
    for worse in (test.bad, test.bad - 0.05):
        accepted, _ = decisions(test, worse)
        assert 0.0 < accepted <= test.errors


def test_few_runs_are_enough() -> None:
    means = {rate: decisions(TEST, rate)[1] for rate in (0.8, 0.9, 0.97)}
    assert {rate: round(mean) for rate, mean in means.items()} == {0.8: 19, 0.9: 58, 0.97: 76}


def test_the_first_decisions() -> None:
    passing = next(runs for runs in range(1, 100) if TEST.decide(runs, 0) is not Decision.OPEN)
    failing = next(runs for runs in range(1, 100) if TEST.decide(0, runs) is not Decision.OPEN)
    assert (passing, TEST.decide(passing, 0)) == (40, Decision.GOOD)
    assert (failing, TEST.decide(0, failing)) == (3, Decision.BAD)
    assert TEST.decide(20, 1) is Decision.OPEN

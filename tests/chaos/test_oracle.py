"""The oracle of the chaos test, with violations and correct rounds."""

from dataclasses import replace
from typing import Any

import pytest

from tests.chaos.oracle import Found, FoundRun, Received, violations
from tests.chaos.plan import Submission, draw

DRIVE = Submission(0, "drive", "lab-a", "turtlebot4", 0.0, 1.0, waits=True)
FAIL = Submission(1, "fail", "lab-a", "", 0.0, 1.0, waits=True)


def trace(begin: int = 0, end: int = 9) -> list[dict[str, Any]]:
    walls = [f"2026-01-01T00:00:0{second}" for second in (begin, end)]
    return [{"seq": 0, "kind": "run.start", "wall": walls[0]}, {"seq": 1, "kind": "run.end", "wall": walls[1]}]


RUN = FoundRun("aa", "lab-a", "client_0.osc", "passed", "", trace())
RECEIVED = Received(DRIVE, "aa", "passed")
GOOD = Found((RECEIVED,), (RUN,))


def test_a_round_without_a_fault_has_no_violation() -> None:
    assert violations(GOOD) == []


@pytest.mark.parametrize(
    "found",
    [
        Found((Received(DRIVE, "aa", reason="the executor is gone"),), (replace(RUN, state="lost", records=[]),)),
        Found((Received(DRIVE, "aa"),), (replace(RUN, state="error", reason="the simulator is gone"),)),
        Found((Received(DRIVE),), (RUN,)),  # the acknowledgement was lost
        Found((Received(DRIVE, reason="no executor answers"),), ()),
        Found((Received(FAIL, "bb", "failed"),), (replace(RUN, run="bb", file="client_1.osc", state="failed"),)),
    ],
)
def test_expected_effects_of_faults_are_not_violations(found: Found) -> None:
    assert violations(found) == []


@pytest.mark.parametrize(
    ("found", "violation"),
    [
        (replace(GOOD, runs=()), "was acknowledged, and is lost"),
        (replace(GOOD, runs=(RUN, RUN)), "run aa is there 2 times"),
        (replace(GOOD, runs=(RUN, replace(RUN, run="bb"))), "client_0.osc was run 2 times"),
        (replace(GOOD, runs=(replace(RUN, state="queued"),)), "has no end: queued"),
        (replace(GOOD, runs=(replace(RUN, state="failed"),)), "failed, and the scenario is right"),
        (replace(GOOD, runs=(replace(RUN, state="invalid"),)), "is invalid, and the scenario is not"),
        (replace(GOOD, received=(replace(RECEIVED, verdict="failed"),)), "received `failed` for client_0.osc"),
        (replace(GOOD, received=(replace(RECEIVED, invalid="no bridge"),)), "received client_0.osc as invalid"),
        (replace(GOOD, runs=(replace(RUN, records=trace()[1:]),)), "has gaps or doubles"),
        (replace(GOOD, runs=(replace(RUN, records=trace()[:1]),)), "has no end"),
        (replace(GOOD, held={"turtlebot4": "a run"}), "turtlebot4 is still held"),
        (replace(GOOD, left=("7: python",)), "left behind: 7: python"),
        (replace(GOOD, unreachable=("lab-b",)), "lab-b does not answer"),
        (Found((Received(FAIL, "bb", "passed"),), ()), "received `passed` for client_1.osc"),
    ],
)
def test_a_broken_guarantee_is_a_violation(found: Found, violation: str) -> None:
    assert any(violation in each for each in violations(found))


def test_two_runs_that_drive_one_robot_at_the_same_time_are_a_violation() -> None:
    other = replace(DRIVE, number=2)
    runs = (
        replace(RUN, records=trace(0, 4)),
        FoundRun("bb", "lab-b", "client_2.osc", "passed", "", trace(3, 6)),
    )
    found = Found((RECEIVED, Received(other, "bb", "passed")), runs)
    assert "turtlebot4 was driven by the runs aa and bb at the same time" in violations(found)
    assert violations(replace(found, runs=(runs[0], replace(runs[1], records=trace(4, 6))))) == []


def test_a_seed_gives_the_same_round_again() -> None:
    assert [draw(seed) for seed in range(50)] == [draw(seed) for seed in range(50)]
    assert len({draw(seed).faults for seed in range(50)}) == 50

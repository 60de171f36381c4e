"""Rules of bridges that navigate and of arms: a robot that keeps them, and one for each way to break them."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges.conformance import (
    BRIDGE_LEVELS,
    BridgeRule,
    BrokenRule,
    HeldRobot,
    advice,
    check_bridge_rule,
    requirement,
)
from seoro.bridges.conformance import bridge_arms as arms
from seoro.bridges.conformance import bridge_navigation as goals
from tests.bridges.robot.toy_robot import NAME, toy

pytestmark = pytest.mark.anyio


@pytest.fixture(autouse=True)
def impatient(monkeypatch: pytest.MonkeyPatch) -> None:
    """Shorten the time limits: the toy is fast."""
    for module in (goals, arms):
        monkeypatch.setattr(module, "LIMIT", 3.0)
    monkeypatch.setattr(goals, "STOPPING", 0.2)
    monkeypatch.setattr(goals, "MOVING", 0.2)
    monkeypatch.setattr(arms, "PLANNED", 0.2)
    monkeypatch.setattr(arms, "STOPPING", 0.1)
    monkeypatch.setattr(arms, "MOVING", 0.1)


@pytest.mark.parametrize("faults", [(), ("aborts late",)])
async def test_a_good_robot_keeps_all_rules(tmp_path: Path, faults: tuple[str, ...]) -> None:
    async with toy(tmp_path, *faults) as (node, endpoint):
        held = HeldRobot(node, NAME, endpoint)
        rules = arms.HANDLING if faults else (*goals.NAVIGATING, *arms.HANDLING)
        for rule in rules:
            await check_bridge_rule(rule, held)


FAULTS: list[tuple[str, BridgeRule, str]] = [
    ("is not localised", goals.navigating_robots_have_a_pose, "the localisation of toy has no pose"),
    ("has an invalid pose", goals.navigating_robots_have_a_pose, "the pose of toy is not finite"),
    (
        "accepts goals without poses",
        goals.impossible_goals_are_refused,
        "a goal without poses is not refused",
    ),
    ("accepts invalid goals", goals.impossible_goals_are_refused, "a goal at x = nan m is not refused"),
    ("stops early", goals.goals_near_by_are_reached, "m from it; expected 0.3 m at most"),
    ("never arrives", goals.goals_near_by_are_reached, "was reported as nothing, not once as succeeded"),
    ("sends no feedback", goals.feedback_approaches_the_goal, "no feedback arrived"),
    ("sends growing distances", goals.feedback_approaches_the_goal, "the remaining distance grows from"),
    ("sends invalid distances", goals.feedback_approaches_the_goal, "the remaining distance is inf m"),
    ("sends times that go back", goals.feedback_approaches_the_goal, "the time of navigation goes back"),
    ("accepts several goals", goals.navigating_robots_are_busy, "a second goal of a navigating robot is not"),
    ("coasts", goals.cancelled_goals_end, "a robot whose goal was cancelled 0.2 s ago moved by"),
    ("describes no arm", arms.arms_have_joints_with_positions, "the description of toy has no arm"),
    ("does not know a joint", arms.arms_have_joints_with_positions, "no finite position of the joints elbow"),
    ("accepts invalid positions", arms.impossible_motions_are_refused, "positions that are not numbers is not"),
    ("accepts missing joints", arms.impossible_motions_are_refused, "a position for each joint but one is not"),
    ("accepts unknown joints", arms.impossible_motions_are_refused, "positions of unknown joints is not refused"),
    ("accepts any position", arms.limits_of_joints_are_kept, "a motion of the first joint to 1000 was accepted"),
    ("stops early", arms.small_motions_are_reached, "the first joint [rad, m] is 1 instead of 0.95"),
    ("accepts several goals", arms.moving_arms_are_busy, "a second motion of a moving arm is not refused"),
    ("coasts", arms.cancelled_motions_end, "an arm whose motion was cancelled 0.1 s ago moved a joint by"),
    ("ignores the speed", arms.cancelled_motions_end, "a motion at 2% of the speed has ended after 0.1 s"),
    ("clips openings", arms.grippers_open_and_close, "an opening of -0.01 m is not refused"),
    ("does not close", arms.grippers_open_and_close, "the opening of the gripper [m] is 0.02 instead of 0"),
]


@pytest.mark.parametrize(
    ("fault", "rule", "words"), FAULTS, ids=[f"{rule.__name__}-{fault}" for fault, rule, _ in FAULTS]
)
async def test_each_fault_breaks_its_rule(tmp_path: Path, fault: str, rule: BridgeRule, words: str) -> None:
    async with toy(tmp_path, fault) as (node, endpoint):
        with pytest.raises(BrokenRule) as broken:
            await check_bridge_rule(rule, HeldRobot(node, NAME, endpoint))
    assert str(broken.value).startswith(requirement(rule))
    assert words in broken.value.fault


def test_each_rule_that_moves_a_robot_has_faults_and_advice() -> None:
    tested = {rule for _, rule, _ in FAULTS}
    assert tested == {*goals.NAVIGATING, *arms.HANDLING}
    assert {rule for level in ("navigate", "arm") for rule in BRIDGE_LEVELS[level]} >= tested
    assert all(advice(rule) for rule in tested)

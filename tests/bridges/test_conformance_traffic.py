"""Conformance of nodes with people, robots on paths, doors and lifts, and of nodes that break a rule."""

from __future__ import annotations

from collections.abc import Sequence

import pytest

from seoro.bridges.conformance import RULES, Rule, check_rule, traffic
from seoro.bridges.conformance.bench import Make
from seoro.bridges.sim.node import SimulatorNode
from seoro.runtime.contracts.backends import Reporter
from seoro.runtime.contracts.people import Point
from tests.bridges.nodes import OPTIONS, Connect
from tests.bridges.spoiling import Spoil, do_nothing, expect_broken, replace_method, spoiled

ALL = tuple(rule for rule in RULES if rule.__module__ == traffic.__name__)


@pytest.fixture
def make(mujoco: Connect) -> Make:
    return mujoco(OPTIONS)


@pytest.mark.parametrize("rule", ALL, ids=lambda rule: rule.__name__)
async def test_mujoco_keeps_the_rules(make: Make, rule: Rule) -> None:
    await check_rule(rule, make)


def slow(node: SimulatorNode) -> None:
    """People walk at half the speed."""
    walk = node.walk_along

    async def spoiled_walk(
        person: str, points: Sequence[Point], place: str, speed: float, report: Reporter, *, repeat: bool
    ) -> str:
        return await walk(person, points, place, speed / 2.0, report, repeat=repeat)

    replace_method(node, walk_along=spoiled_walk)


def endless(node: SimulatorNode) -> None:
    """Goals are never cancelled."""
    replace_method(node, cancel_goal=do_nothing)


def hasty(node: SimulatorNode) -> None:
    """Robots drive to the first point only."""
    follow = node.follow_path

    async def spoiled_follow(
        robot: str, points: Sequence[Point], speed: float, report: Reporter, *, repeat: bool
    ) -> str:
        return await follow(robot, points[:1], speed, report, repeat=repeat)

    replace_method(node, follow_path=spoiled_follow)


def silent(node: SimulatorNode) -> None:
    """Unknown doors and lifts are accepted."""
    replace_method(node, move_door=do_nothing, move_lift=do_nothing)


@pytest.mark.parametrize(
    ("spoil", "rule", "words"),
    [
        (slow, traffic.people_walk_to_their_last_point, "the duration of a walk of 2 m at 0.5 m/s [s]"),
        (endless, traffic.people_stop_when_their_goal_is_cancelled, "the motion of a person without a goal"),
        (hasty, traffic.robots_follow_paths_by_their_true_pose, "instead of (1.2, 0.6)"),
        (endless, traffic.repeated_paths_end_by_cancellation, "a robot whose path was cancelled moved"),
        (silent, traffic.unknown_doors_are_refused, "the opening of an unknown door is not refused"),
        (silent, traffic.unknown_lifts_are_refused, "a motion of an unknown lift is not refused"),
    ],
)
async def test_nodes_with_a_fault_break_a_rule(make: Make, spoil: Spoil, rule: Rule, words: str) -> None:
    await expect_broken(rule, words, spoiled(make, spoil))

"""Conformance of nodes with an arm, and of backends that break a rule."""

from __future__ import annotations

import asyncio
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import pytest

from seoro.bridges.conformance import ArmFacts, Make, Rule, arms, check_arm
from seoro.bridges.sim.node import SimulatorNode
from seoro.errors import BackendRefused
from seoro.robotics.geometry import Pose3D
from seoro.runtime.contracts.backends import GoalStatus, Report, Reporter
from seoro.runtime.contracts.robots import MotionOptions
from tests.bridges.nodes import CELL, Connect, running
from tests.bridges.spoiling import Spoil, do_nothing, expect_broken, replace_method, spoiled

UR10E = ArmFacts(
    joints=(
        "shoulder_pan_joint",
        "shoulder_lift_joint",
        "elbow_joint",
        "wrist_1_joint",
        "wrist_2_joint",
        "wrist_3_joint",
    ),
    postures=((0.0, -1.5708, 1.5708, -1.5708, -1.5708, 0.0), (0.8, -1.3, 1.3, -1.6, -1.5, 0.5)),
    opening=0.085,
)


@pytest.fixture
def make(mujoco: Connect) -> Make:
    return mujoco(CELL)


async def test_an_arm_in_mujoco_fulfils_the_contract(make: Make) -> None:
    await check_arm(make, UR10E)


@pytest.mark.more
async def test_an_arm_in_pybullet_fulfils_the_contract(tmp_path: Path) -> None:
    pytest.importorskip("pybullet", reason="the engine pybullet is not installed")
    with running("pybullet", tmp_path, CELL) as making:
        await check_arm(making, UR10E)


# ---------------------------------------------------------------- backends with a fault


def short(node: SimulatorNode) -> None:
    """Move nine tenths of the way."""
    move = node.move_joints

    async def spoiled(
        robot: str, positions: Sequence[float], names: Sequence[str], options: MotionOptions, report: Reporter
    ) -> str:
        return await move(robot, [0.9 * position for position in positions], names, options, report)

    replace_method(node, move_joints=spoiled)


def repetitive(node: SimulatorNode) -> None:
    """Report the end of a motion twice."""
    move = node.move_joints

    async def spoiled(
        robot: str, positions: Sequence[float], names: Sequence[str], options: MotionOptions, report: Reporter
    ) -> str:
        def twice(answered: Report) -> None:
            report(answered)
            report(answered)

        return await move(robot, positions, names, options, twice)

    replace_method(node, move_joints=spoiled)


def stubborn(node: SimulatorNode) -> None:
    """Ignore cancellations of motions."""
    replace_method(node, cancel_goal=do_nothing)


def credulous(node: SimulatorNode) -> None:
    """Accept every pose, and abort the motion later."""
    move = node.move_tool

    async def spoiled(
        robot: str, pose: Pose3D, frame: str, options: MotionOptions, report: Reporter, *, straight: bool
    ) -> str:
        try:
            return await move(robot, pose, frame, options, report, straight=straight)
        except BackendRefused:
            return "taken"

    replace_method(node, move_tool=spoiled)


def fickle(node: SimulatorNode) -> None:
    """Accept another motion during a motion."""
    move, taken = node.move_joints, list[str]()

    async def spoiled(
        robot: str, positions: Sequence[float], names: Sequence[str], options: MotionOptions, report: Reporter
    ) -> str:
        for goal in taken:
            await node.cancel_goal(goal)
        taken.append(await move(robot, positions, names, options, report))
        return taken[-1]

    replace_method(node, move_joints=spoiled)


def eager(node: SimulatorNode) -> None:
    """Move instead of planning only."""
    move = node.move_joints

    async def spoiled(
        robot: str, positions: Sequence[float], names: Sequence[str], options: MotionOptions, report: Reporter
    ) -> str:
        return await move(robot, positions, names, replace(options, plan_only=False), report)

    replace_method(node, move_joints=spoiled)


def limp(node: SimulatorNode) -> None:
    """Report success without moving the gripper."""

    async def spoiled(
        robot: str, opening: float, force: float | None, options: MotionOptions, report: Reporter
    ) -> str:
        asyncio.get_running_loop().call_soon(report, Report(GoalStatus.SUCCEEDED))
        return "done"

    replace_method(node, move_gripper=spoiled)


def nervous(node: SimulatorNode) -> None:
    """Its watches of joints fire at once."""
    watch = node.watch_joint

    async def spoiled(robot: str, joint: str, position: float, tolerance: float, report: Reporter) -> str:
        return await watch(robot, joint, position, 10.0, report)

    replace_method(node, watch_joint=spoiled)


@pytest.mark.parametrize(
    ("spoil", "rule", "words"),
    [
        (short, arms.arms_reach_their_goals, "is not near -1.5708 rad, its goal"),
        (repetitive, arms.arms_reach_their_goals, "reported as succeeded, succeeded"),
        (stubborn, arms.cancelled_motions_end_and_arms_stop, "whose motion was cancelled 1 s ago moved"),
        (credulous, arms.impossible_motions_are_refused, "a pose 100 m away is not refused"),
        (fickle, arms.a_moving_arm_is_busy, "a second motion of a moving arm is not refused"),
        (eager, arms.plans_move_nothing, "an arm with `plan_only` moved its tool"),
        (limp, arms.grippers_open_and_close, "the opening of the gripper [m] is 0.085 instead of 0"),
        (nervous, arms.joints_are_watched, "fired far from there"),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
async def test_arms_with_a_fault_break_a_rule(make: Make, spoil: Spoil, rule: Rule, words: str) -> None:
    await expect_broken(rule, words, spoiled(make, spoil), UR10E)

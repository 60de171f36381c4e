"""Rules about arms with grippers: motions, refusals, gripping, watches of joints.

The entities that an arm can hold depend on the world, so the rules close the gripper on nothing.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable
from dataclasses import dataclass

from seoro.bridges.conformance.bench import (
    Bench,
    Reports,
    SimulatedBackend,
    expect,
    expect_cancelled,
    expect_near,
    expect_refused,
    expect_reported,
    place,
)
from seoro.bridges.wire import Result
from seoro.runtime.contracts.backends import GoalStatus
from seoro.runtime.contracts.robots import Arms, MotionOptions

ARM = ("arm", "robot", "osc_actor")
SUCCEEDED = GoalStatus.SUCCEEDED
LONG = 30.0  # [s] time limit of motions
SETTLED = 2.0  # deviation of joints shortly after a motion, as a multiple of the tolerance
SLOW = 0.2  # fraction of the speed, for motions that are cancelled
STILL = 1e-3  # [m] movement of the tool of a standing arm in a second
TOLERANCE = 5e-3  # [rad]
GRIP_TOLERANCE = 2e-3  # [m]


@dataclass(frozen=True)
class ArmFacts:
    """Facts about the arm, for the rules.

    Args:
        joints: Names of its joints, from the base on.
        postures: Two configurations [rad]. The linear paths of all joints from the initial configuration to the
            first, and between the two, are free of obstacles. The positions of the tool differ by at least 5 cm.
        opening: Opening of its gripper [m].
    """

    joints: tuple[str, ...]
    postures: tuple[tuple[float, ...], tuple[float, ...]]
    opening: float


class ArmBench(Bench):
    """An arm in a run that has just started.

    Args:
        facts: Facts about the arm.
        backend: The backend.
        robot: Name of the arm.
    """

    def __init__(self, facts: ArmFacts, backend: SimulatedBackend, robot: str) -> None:
        super().__init__(backend, robot)
        self.facts, self.arms = facts, self.cast(Arms)

    def send(
        self, posture: int, reports: Reports, *, scaling: float = 1.0, plan_only: bool = False
    ) -> Awaitable[str]:
        """Send the arm to one of its two postures, at a fraction of its speed."""
        options = MotionOptions(scaling, TOLERANCE, (), plan_only)
        return self.arms.move_joints(self.robot, self.facts.postures[posture], (), options, reports)

    async def reach(self, posture: int) -> None:
        """Send the arm to a posture, and wait until it is reached."""
        reports = Reports()
        await self.send(posture, reports)
        await self.expect_end(f"a motion to {self.facts.postures[posture]} [rad]", reports, LONG)

    async def tool(self) -> tuple[float, float, float]:
        """Return the position of the tool in the map [m]."""
        position = (await self.arms.arm_state(self.robot)).tool.position
        return position.x, position.y, position.z

    async def expect_tool_still(self, what: str, before: tuple[float, float, float]) -> None:
        """Expect the tool to stay at a position for a second."""
        await self.pass_time(1.0)
        moved = math.dist(before, await self.tool())
        expect(moved < STILL, f"{what} moved its tool by {moved:.4f} m")


async def arms_reach_their_goals(arm: ArmBench) -> None:
    """An arm reaches the posture of its goal within the tolerance, and reports it once."""
    reports = Reports()
    goal = await arm.send(0, reports)
    await arm.expect_end("a motion of joints", reports, LONG)
    for joint, position in zip(arm.facts.joints, arm.facts.postures[0], strict=True):
        there = Reports()
        await arm.arms.watch_joint(arm.robot, joint, position, SETTLED * TOLERANCE, there)
        await arm.pass_until(arm.time + 0.1, there.any)
        expect(there.any(), f"{joint!r} is not near {position} rad, its goal")
    await arm.pass_time(1.0)
    expect_reported("a motion that has ended", reports, SUCCEEDED)
    await arm.arms.cancel_goal(goal)
    expect_reported("a motion that was cancelled after its end", reports, SUCCEEDED)


async def cancelled_motions_end_and_arms_stop(arm: ArmBench) -> None:
    """An arm whose motion is cancelled stands still within a second, and accepts another motion."""
    await arm.reach(0)
    first, reports = await arm.tool(), Reports()
    goal = await arm.send(1, reports, scaling=SLOW)
    moves = await _moves(arm, first)
    expect(moves and not reports.all, "an arm with another goal did not move, or its motion ended at once")
    await arm.arms.cancel_goal(goal)
    await arm.pass_time(1.0)
    await arm.expect_tool_still("an arm whose motion was cancelled 1 s ago", await arm.tool())
    expect_cancelled("a cancelled motion", reports)
    await arm.reach(0)
    off = math.dist(first, await arm.tool())
    expect(off < 0.02, f"after a cancelled motion and the way back, the tool is off by {off:.3f} m")


async def _moves(arm: ArmBench, first: tuple[float, float, float]) -> bool:
    """Grant time until the tool has moved by 1 cm; False if it does not."""
    for _ in range(40):
        await arm.pass_time(0.05)
        if math.dist(first, await arm.tool()) > 0.01:
            return True
    return False


async def impossible_motions_are_refused(arm: ArmBench) -> None:
    """Goals out of reach, of unknown robots, with invalid numbers or for other joints are refused."""
    before = await arm.tool()

    async def reach(robot: str, x: float, frame: str = "map", *, straight: bool = False) -> None:
        await arm.arms.move_tool(robot, place(x, 0.0, 1.0), frame, MotionOptions(), Reports(), straight=straight)

    async def join(*positions: float, names: tuple[str, ...] = ()) -> None:
        await arm.arms.move_joints(arm.robot, positions, names, MotionOptions(), Reports())

    count = len(arm.facts.joints)
    for straight in (False, True):
        await expect_refused("a pose 100 m away", reach(arm.robot, 100.0, straight=straight))
    await expect_refused("a pose that is not a number", reach(arm.robot, math.nan))
    await expect_refused("a pose in an unknown frame", reach(arm.robot, 0.5, "nowhere"), Result.NOT_FOUND)
    await expect_refused("a motion of an unknown arm", reach("nobody", 0.5), Result.NOT_FOUND)
    await expect_refused("a position for each joint but one", join(*arm.facts.postures[0][1:]))
    await expect_refused("positions that are not numbers", join(*(math.nan for _ in range(count))))
    await expect_refused("positions of 1000 rad", join(*(1000.0 for _ in range(count))))
    others = tuple(f"other_{joint}" for joint in arm.facts.joints)
    await expect_refused("positions of unknown joints", join(*arm.facts.postures[0], names=others))
    await arm.expect_tool_still("an arm whose requests were refused", before)


async def a_moving_arm_is_busy(arm: ArmBench) -> None:
    """A second motion of a moving arm is refused, and the first continues."""
    reports = Reports()
    await arm.send(0, reports)
    await expect_refused("a second motion of a moving arm", arm.send(1, Reports()))
    await arm.expect_end("a motion during which another was refused", reports, LONG)


async def plans_move_nothing(arm: ArmBench) -> None:
    """A motion with `plan_only` succeeds, is reported once, and moves nothing."""
    reports = Reports()
    await arm.reach(0)
    before = await arm.tool()
    await arm.send(1, reports, plan_only=True)
    await arm.expect_end("a plan", reports, LONG)
    await arm.expect_tool_still("an arm with `plan_only`", before)
    expect_reported("a plan that has ended", reports, SUCCEEDED)


async def grippers_open_and_close(arm: ArmBench) -> None:
    """A gripper reaches the requested openings, and holds nothing without an entity between its fingers."""
    options = MotionOptions(tolerance=GRIP_TOLERANCE)
    for opening in (0.0, arm.facts.opening, arm.facts.opening / 2):
        reports = Reports()
        await arm.arms.move_gripper(arm.robot, opening, None, options, reports)
        await arm.expect_end(f"a gripper with the goal {opening:g} m", reports, LONG)
        state = await arm.arms.arm_state(arm.robot)
        expect_near("the opening of the gripper [m]", state.opening, opening, SETTLED * GRIP_TOLERANCE)
    expect(state.held == "", f"a gripper that closed on nothing reports that it holds {state.held!r}")
    hold = arm.arms.hold_entity(arm.robot, "", 1.0, Reports())
    await expect_refused("a hold by an empty gripper", hold)
    for opening in (-0.01, 10.0, math.nan):
        move = arm.arms.move_gripper(arm.robot, opening, None, options, Reports())
        await expect_refused(f"an opening of {opening} m", move)


async def joints_are_watched(arm: ArmBench) -> None:
    """A watch of a joint fires once, when the joint passes a position, unless it is cancelled."""
    near, silent, ended = Reports(), Reports(), Reports()
    await arm.reach(0)
    joint, halfway = _farthest(arm.facts)
    await arm.arms.watch_joint(arm.robot, joint, halfway, 0.01, near)
    await arm.arms.cancel_watch(await arm.arms.watch_joint(arm.robot, joint, halfway, 0.01, silent))
    await arm.pass_time(0.2)
    expect(not near.all, f"a watch of {joint!r} at {halfway:.3f} rad fired far from there")
    await arm.send(1, ended)
    await arm.expect_end(f"a watch of {joint!r} at {halfway:.3f} rad", near, LONG)
    expect(not ended.all, "the watch of a joint halfway was reported after the end of the motion")
    await arm.pass_until(arm.time + LONG, ended.any)
    expect_reported("a watch of a joint that has fired", near, SUCCEEDED)
    expect(not silent.all, "a cancelled watch of a joint was reported")
    unknown = arm.arms.watch_joint(arm.robot, "no_joint", 0.0, 0.01, Reports())
    await expect_refused("a watch of an unknown joint", unknown, Result.NOT_FOUND)


def _farthest(facts: ArmFacts) -> tuple[str, float]:
    """Return the joint with the largest difference between the postures, and its mean position [rad]."""
    joint, one, other = max(
        zip(facts.joints, *facts.postures, strict=True), key=lambda joint: abs(joint[1] - joint[2])
    )
    return joint, (one + other) / 2

"""Rules about arms with grippers: goals of joints, what is refused, gripping, watches of joints.

What an arm holds depends on what there is to hold; the rules look at fingers that close on nothing.
"""

from __future__ import annotations

import math
from collections.abc import Awaitable
from dataclasses import dataclass

from seoro.bridges.conformance.bench import (
    Bench,
    Make,
    Reports,
    expect,
    expect_near,
    expect_refused,
    expect_reported,
    place,
    started,
)
from seoro.bridges.wire import Result
from seoro.runtime.capabilities import Arms, Manner
from seoro.runtime.contracts import GoalStatus

ARM = ("arm", "robot", "osc_actor")
SUCCEEDED = GoalStatus.SUCCEEDED
LONG = 30.0  # [s] in which any motion of the rules has to end
SETTLED = 2.0  # times the tolerance that joints may be off a moment after the end of a motion
SLOW = 0.2  # part of its speed with which an arm moves that is to be stopped on its way
STILL = 1e-3  # [m] that the tool of an arm that stands may move in a second
TOLERANCE = 5e-3  # [rad]
GRIP_TOLERANCE = 2e-3  # [m]


@dataclass(frozen=True)
class ArmFacts:
    """What rules have to know of the arm that they move.

    Args:
        joints: Names of its joints, in the order of the arm.
        postures: Two configurations [rad] that nothing is in the way of, nor of the way from the arm's first
            configuration to the first of them, and from each to the other when all joints move evenly. The tool
            has to be elsewhere in the other by 5 cm.
        opening: How far its gripper opens [m].
    """

    joints: tuple[str, ...]
    postures: tuple[tuple[float, ...], tuple[float, ...]]
    opening: float


class ArmBench:
    """An arm in a run that has just started.

    Args:
        bench: The run.
        facts: What is known of the arm.
    """

    def __init__(self, bench: Bench, facts: ArmFacts) -> None:
        self.bench, self.facts = bench, facts
        self.arms = bench.can(Arms)

    def send(
        self, posture: int, reports: Reports, *, scaling: float = 1.0, plan_only: bool = False
    ) -> Awaitable[str]:
        """Send the arm to one of its two postures, with a part of its speed."""
        manner = Manner(scaling, TOLERANCE, (), plan_only)
        return self.arms.move_joints(self.bench.robot, self.facts.postures[posture], (), manner, reports)

    async def bring(self, posture: int) -> None:
        """Send it to a posture, and wait until it is there."""
        reports = Reports()
        await self.send(posture, reports)
        await self.bench.pass_until(self.bench.time + LONG, reports.any)
        expect_reported(f"a motion to {self.facts.postures[posture]} [rad]", reports, SUCCEEDED)

    async def tool(self) -> tuple[float, float, float]:
        """Where the tool is in the map [m]."""
        position = (await self.arms.arm_state(self.bench.robot)).tool.position
        return position.x, position.y, position.z

    async def opening(self) -> float:
        """How far the gripper is open [m]."""
        return (await self.arms.arm_state(self.bench.robot)).opening

    async def expect_still(self, what: str, place_before: tuple[float, float, float]) -> None:
        """Expect the tool to be where it was, now and in a second."""
        await self.bench.pass_time(1.0)
        moved = math.dist(place_before, await self.tool())
        expect(moved < STILL, f"{what} moved its tool by {moved:.4f} m")


async def arms_come_to_their_goals(make: Make, facts: ArmFacts) -> None:
    """An arm that is sent to a posture comes there within the tolerance, and says so once."""
    async with started(make, ARM) as bench:
        arm = ArmBench(bench, facts)
        reports = Reports()
        goal = await arm.send(0, reports)
        await bench.pass_until(LONG, reports.any)
        expect_reported("a motion of joints", reports, SUCCEEDED)
        for joint, position in zip(facts.joints, facts.postures[0], strict=True):
            there = Reports()
            await arm.arms.watch_joint(bench.robot, joint, position, SETTLED * TOLERANCE, there)
            await bench.pass_until(bench.time + 0.1, there.any)
            expect(there.any(), f"{joint!r} is not near {position} rad, which it was sent to")
        await bench.pass_time(1.0)
        expect_reported("a motion that has ended", reports, SUCCEEDED)
        await arm.arms.cancel_goal(goal)
        expect_reported("a motion that was cancelled after its end", reports, SUCCEEDED)


async def cancelled_motions_end_and_arms_stop(make: Make, facts: ArmFacts) -> None:
    """An arm whose motion is cancelled stands still within a second, and can be sent elsewhere."""
    async with started(make, ARM) as bench:
        arm = ArmBench(bench, facts)
        await arm.bring(0)
        first, reports = await arm.tool(), Reports()
        goal = await arm.send(1, reports, scaling=SLOW)
        moves = await _moves(arm, first)
        expect(moves and not reports.all, "an arm that was sent elsewhere did not move, or has ended at once")
        await arm.arms.cancel_goal(goal)
        await bench.pass_time(1.0)
        await arm.expect_still("an arm whose motion was cancelled 1 s ago", await arm.tool())
        expect(
            reports.statuses in ([], ["canceled"]),
            f"a cancelled motion was reported as {', '.join(reports.statuses)}",
        )
        await arm.bring(0)
        off = math.dist(first, await arm.tool())
        expect(off < 0.02, f"sent back after a motion that was cancelled, the tool is off by {off:.3f} m")


async def _moves(arm: ArmBench, first: tuple[float, float, float]) -> bool:
    """Let time pass until the tool has moved a little; False if it does not."""
    for _ in range(40):
        await arm.bench.pass_time(0.05)
        if math.dist(first, await arm.tool()) > 0.01:
            return True
    return False


async def impossible_motions_are_refused(make: Make, facts: ArmFacts) -> None:
    """What is out of reach, of nobody, no number, or for other joints is refused, and nothing moves."""
    async with started(make, ARM) as bench:
        arm = ArmBench(bench, facts)
        before = await arm.tool()

        async def reach(robot: str, x: float, frame: str = "map", *, straight: bool = False) -> None:
            await arm.arms.move_tool(robot, place(x, 0.0, 1.0), frame, Manner(), Reports(), straight=straight)

        async def join(*positions: float, names: tuple[str, ...] = ()) -> None:
            await arm.arms.move_joints(bench.robot, positions, names, Manner(), Reports())

        count = len(facts.joints)
        for straight in (False, True):
            await expect_refused("a pose 100 m away", reach(bench.robot, 100.0, straight=straight))
        await expect_refused("a pose that is no number", reach(bench.robot, math.nan))
        await expect_refused("a pose in an unknown frame", reach(bench.robot, 0.5, "nowhere"), Result.NOT_FOUND)
        await expect_refused("a motion of an unknown arm", reach("nobody", 0.5), Result.NOT_FOUND)
        await expect_refused("a position for each joint but one", join(*facts.postures[0][1:]))
        await expect_refused("positions that are no numbers", join(*(math.nan for _ in range(count))))
        await expect_refused("positions of 1000 rad", join(*(1000.0 for _ in range(count))))
        others = tuple(f"other_{joint}" for joint in facts.joints)
        await expect_refused("positions of unknown joints", join(*facts.postures[0], names=others))
        await arm.expect_still("an arm that was asked for what is impossible", before)


async def a_moving_arm_is_busy(make: Make, facts: ArmFacts) -> None:
    """A second motion of an arm that moves is refused, and the first goes on."""
    async with started(make, ARM) as bench:
        arm, reports = ArmBench(bench, facts), Reports()
        await arm.send(0, reports)
        await expect_refused("a second motion of an arm that moves", arm.send(1, Reports()))
        await bench.pass_until(LONG, reports.any)
        expect_reported("a motion, while another was refused,", reports, SUCCEEDED)


async def what_is_only_planned_moves_nothing(make: Make, facts: ArmFacts) -> None:
    """A motion that is only planned succeeds, is reported once, and moves nothing."""
    async with started(make, ARM) as bench:
        arm, reports = ArmBench(bench, facts), Reports()
        await arm.bring(0)
        before = await arm.tool()
        await arm.send(1, reports, plan_only=True)
        await bench.pass_until(bench.time + LONG, reports.any)
        expect_reported("a plan", reports, SUCCEEDED)
        await arm.expect_still("an arm that was to plan only", before)
        expect_reported("a plan that has ended", reports, SUCCEEDED)


async def grippers_open_and_close(make: Make, facts: ArmFacts) -> None:
    """A gripper comes to the openings that it is sent to, and holds nothing where there is nothing."""
    async with started(make, ARM) as bench:
        arm = ArmBench(bench, facts)
        manner = Manner(tolerance=GRIP_TOLERANCE)
        for opening in (0.0, facts.opening, facts.opening / 2):
            reports = Reports()
            await arm.arms.move_gripper(bench.robot, opening, None, manner, reports)
            await bench.pass_until(bench.time + LONG, reports.any)
            expect_reported(f"a gripper that was sent to {opening:g} m", reports, SUCCEEDED)
            expect_near("how far it is open [m]", await arm.opening(), opening, SETTLED * GRIP_TOLERANCE)
        state = await arm.arms.arm_state(bench.robot)
        expect(state.held == "", f"a gripper that has closed on nothing says that it holds {state.held!r}")
        hold = arm.arms.hold_entity(bench.robot, "", 1.0, Reports())
        await expect_refused("to hold what is held by a gripper that holds nothing", hold)
        for opening in (-0.01, 10.0, math.nan):
            move = arm.arms.move_gripper(bench.robot, opening, None, manner, Reports())
            await expect_refused(f"an opening of {opening} m", move)


async def joints_are_watched(make: Make, facts: ArmFacts) -> None:
    """A watch of a joint fires once, when it comes past a position, and not when it is cancelled."""
    async with started(make, ARM) as bench:
        arm, near, silent, ended = ArmBench(bench, facts), Reports(), Reports(), Reports()
        await arm.bring(0)
        joint, halfway = _farthest(facts)
        await arm.arms.watch_joint(bench.robot, joint, halfway, 0.01, near)
        await arm.arms.cancel_watch(await arm.arms.watch_joint(bench.robot, joint, halfway, 0.01, silent))
        await bench.pass_time(0.2)
        expect(not near.all, f"a watch of {joint!r} at {halfway:.3f} rad has fired far from there")
        await arm.send(1, ended)
        await bench.pass_until(bench.time + LONG, near.any)
        expect_reported(f"a watch of {joint!r} at {halfway:.3f} rad", near, SUCCEEDED)
        expect(not ended.all, "the watch of a joint halfway was told when the motion had ended")
        await bench.pass_until(bench.time + LONG, ended.any)
        expect_reported("a watch of a joint that has fired", near, SUCCEEDED)
        expect(not silent.all, "a watch of a joint that was cancelled was reported")
        unknown = arm.arms.watch_joint(bench.robot, "no_joint", 0.0, 0.01, Reports())
        await expect_refused("a watch of an unknown joint", unknown, Result.NOT_FOUND)


def _farthest(facts: ArmFacts) -> tuple[str, float]:
    """The joint that is farthest apart in the postures, and the middle of its way [rad]."""
    joint, one, other = max(
        zip(facts.joints, *facts.postures, strict=True), key=lambda each: abs(each[1] - each[2])
    )
    return joint, (one + other) / 2

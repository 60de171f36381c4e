"""Rules of bridges to arms: small motions of the first joint, limits, cancellation, and the gripper.

Goals are the first position of the joint and one `OFFSET` from it, towards zero, in turn.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import anyio

from seoro.bridges import wire
from seoro.bridges.conformance.bench import (
    Reports,
    expect,
    expect_cancelled,
    expect_near,
    expect_refused,
    expect_reported,
)
from seoro.bridges.conformance.bridges import AwaitedReports, BridgeRule, HeldRobot
from seoro.bridges.wire import Result
from seoro.errors import BackendRefused
from seoro.runtime.contracts.backends import GoalStatus, Reporter
from seoro.runtime.contracts.robots import MotionOptions

OFFSET = 0.05  # [rad, m] of the first joint
FAR = 1000.0  # [rad, m] beyond the limits of every joint
TOLERANCE = 0.01  # [rad, m]
USUAL, SLOW, SLOWEST = 0.1, 0.02, 1e-5  # shares of the maximum speed
LIMIT = 30.0  # [s] until a motion has ended
PLANNED = 10.0  # [s] until a planner has found that a motion is impossible
MOVING = 0.3  # [s] from the start of a motion to its cancellation
STOPPING = 0.5  # [s] from a cancellation until the arm stands
STILL = 2e-3  # [rad, m] movement of a standing joint
OPENING_TOLERANCE = 5e-3  # [m]


async def _description(held: HeldRobot) -> wire.ArmDescription:
    """Return the description of the arm."""
    arm = (await held.node.ask(wire.GET_ROBOT_DESCRIPTION, wire.RobotName(robot=held.robot))).arm
    if arm is None:
        raise AssertionError(f"the description of {held.robot} has no arm")
    expect(0 < len(set(arm.joints)) == len(arm.joints), f"the joints are {arm.joints}; expected distinct names")
    return arm


async def _positions(held: HeldRobot) -> tuple[float, ...]:
    """Return the positions of the joints of the arm."""
    arm = await _description(held)
    states = await held.node.ask(wire.GET_JOINT_STATES, wire.RobotName(robot=held.robot))
    known = dict(zip(states.names, states.positions, strict=False))
    missing = [name for name in arm.joints if not math.isfinite(known.get(name, math.nan))]
    expect(not missing, f"no finite position of the joints {', '.join(missing)}")
    return tuple(known[name] for name in arm.joints)


async def _next_goal(held: HeldRobot) -> tuple[float, ...]:
    """Return the farther one of two goals: the first joint at its first position, or off it."""
    here = await _positions(held)
    start = held.posture = held.posture or here
    off = (start[0] - math.copysign(OFFSET, start[0]), *start[1:])
    return max((start, off), key=lambda goal: abs(goal[0] - here[0]))


async def _move(
    held: HeldRobot, goal: Sequence[float], report: Reporter, scaling: float = USUAL, names: tuple[str, ...] = ()
) -> str:
    """Move the joints of the arm; return the id of the goal."""
    joints = names or (await _description(held)).joints
    return await held.node.move_joints(held.robot, goal, joints, MotionOptions(scaling, TOLERANCE), report)


async def _reach(held: HeldRobot, goal: Sequence[float], what: str) -> None:
    """Move the joints to a goal, and expect them there."""
    reports = AwaitedReports()
    await _move(held, goal, reports)
    await reports.wait(LIMIT)
    expect_reported(what, reports, GoalStatus.SUCCEEDED)
    expect_near("the first joint [rad, m]", (await _positions(held))[0], goal[0], 2.0 * TOLERANCE)


async def _expect_still(held: HeldRobot, what: str, before: Sequence[float]) -> None:
    """Expect the joints at the positions that they had before."""
    moved = max(abs(new - old) for new, old in zip(await _positions(held), before, strict=True))
    expect(moved < STILL, f"{what} moved a joint by {moved:.4f} rad or m")


async def arms_have_joints_with_positions(held: HeldRobot) -> None:
    """An arm lists its joints, and knows the position of each.

    Serve `get_robot_description` and `get_joint_states`. Check the topic of joint states, and the joints of the
    profile.
    """
    await _positions(held)


async def impossible_motions_are_refused(held: HeldRobot) -> None:
    """Motions with invalid numbers, other joints or a wrong number of joints are refused, and the arm stays.

    Check the positions and names of joints before they are sent to the controller.
    """
    before, arm = await _positions(held), await _description(held)
    nan = tuple(math.nan for _ in before)
    others = tuple(f"other_{name}" for name in arm.joints)
    await expect_refused("positions that are not numbers", _move(held, nan, Reports()))
    await expect_refused("a position for each joint but one", _move(held, before[1:], Reports()))
    await expect_refused(
        "positions of unknown joints", _move(held, before, Reports(), names=others), Result.NOT_FOUND
    )
    await _expect_still(held, "an arm whose motions were refused", before)


async def limits_of_joints_are_kept(held: HeldRobot) -> None:
    """A motion beyond the limits of a joint is refused or aborted, and the arm stays.

    Add `limits` of the joints to the profile of the robot, or a motion planner that knows them.
    """
    before, reports = await _positions(held), AwaitedReports()
    try:
        identifier = await _move(held, (math.copysign(FAR, before[0]), *before[1:]), reports, SLOWEST)
    except BackendRefused:
        identifier = ""
    if identifier:
        await reports.wait(PLANNED)
        await held.node.cancel_goal(identifier)
        expect(reports.statuses == ["aborted"], f"a motion of the first joint to {FAR:g} was accepted")
    await _expect_still(held, "a motion beyond the limits", before)


async def small_motions_are_reached(held: HeldRobot) -> None:
    """A joint reaches a position near by within the tolerance, and back; each is reported once.

    Report success when the joints have arrived, and an aborted goal otherwise.
    """
    for what in ("a motion of the first joint", "the motion back"):
        await _reach(held, await _next_goal(held), what)


async def moving_arms_are_busy(held: HeldRobot) -> None:
    """A second motion of a moving arm is refused, and the first one is reached.

    Keep one motion for each arm, and refuse others until its end.
    """
    reports, goal = AwaitedReports(), await _next_goal(held)
    await _move(held, goal, reports, SLOW)
    await expect_refused("a second motion of a moving arm", _move(held, goal, Reports()))
    await reports.wait(LIMIT)
    expect_reported("a motion during which another was refused", reports, GoalStatus.SUCCEEDED)


async def cancelled_motions_end(held: HeldRobot) -> None:
    """An arm whose motion is cancelled stands within half a second, and accepts another motion.

    Cancel the goal at the controller, and reply when the motion has ended.
    """
    reports, goal = AwaitedReports(), await _next_goal(held)
    identifier = await _move(held, goal, reports, SLOW)
    await anyio.sleep(MOVING)
    expect(not reports.all, f"a motion at {SLOW:.0%} of the speed has ended after {MOVING:g} s")
    await held.node.cancel_goal(identifier)
    await anyio.sleep(STOPPING)
    stands = await _positions(held)
    await anyio.sleep(STOPPING)
    await _expect_still(held, f"an arm whose motion was cancelled {STOPPING:g} s ago", stands)
    expect_cancelled("a cancelled motion", reports)
    await _reach(held, goal, "a motion after a cancelled one")


async def grippers_open_and_close(held: HeldRobot) -> None:
    """A gripper opens, closes on nothing, and refuses openings beyond its stroke. Arms without one keep this rule.

    Free the space between the fingers. Check the position of the closed gripper, and its travel for each metre.
    """
    arm = await _description(held)
    if not arm.fingers:
        return
    for opening in (-0.01, arm.stroke + 1.0, math.nan):
        await expect_refused(f"an opening of {opening:g} m", _grip(held, opening, Reports()))
    initial = await _opening(held)
    for opening in (arm.stroke, 0.0, min(max(initial, 0.0), arm.stroke)):
        reports = AwaitedReports()
        await _grip(held, opening, reports)
        await reports.wait(LIMIT)
        expect_reported(f"an opening of {opening:.3f} m", reports, GoalStatus.SUCCEEDED)
        expect_near("the opening of the gripper [m]", await _opening(held), opening, OPENING_TOLERANCE)


async def _opening(held: HeldRobot) -> float:
    return (await held.node.arm_state(held.robot)).opening


async def _grip(held: HeldRobot, opening: float, report: Reporter) -> str:
    options = MotionOptions(tolerance=OPENING_TOLERANCE)
    return await held.node.move_gripper(held.robot, opening, None, options, report)


HANDLING: tuple[BridgeRule, ...] = (
    arms_have_joints_with_positions,
    impossible_motions_are_refused,
    limits_of_joints_are_kept,
    small_motions_are_reached,
    moving_arms_are_busy,
    cancelled_motions_end,
    grippers_open_and_close,
)

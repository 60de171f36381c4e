"""Between what is said on the wire and what the simulation computes with."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import asdict

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.geometry import Pose2, quaternion, roll_pitch_yaw
from sim_nodes.navigation.navigator import Feedback
from sim_nodes.physics import BodyState
from sim_nodes.strikes import Pair, Strike

FARTHEST = 1000.0  # [m]


def planar(pose: wire.Pose) -> Pose2:
    """The pose seen from above.

    Raises:
        RequestRefused: It is no place.
    """
    check_pose(pose, wire.Result.OPERATION_FAILED)
    return Pose2(pose.position.x, pose.position.y, pose.orientation.yaw)


def check_pose(pose: wire.Pose, code: int) -> None:
    """Refuse poses that have parts which are no numbers, or are far off."""
    position, orientation = pose.position, pose.orientation
    place = (position.x, position.y, position.z)
    angles = (orientation.roll, orientation.pitch, orientation.yaw)
    if not all(math.isfinite(value) for value in place + angles) or max(abs(value) for value in place) > FARTHEST:
        raise RequestRefused(code, f"the pose {place}, {angles} is no place within {FARTHEST:.0f} m")


def body_state(pose: wire.Pose, twist: wire.Twist | None = None) -> BodyState:
    """The state of a body at a pose, at rest without a twist."""
    p, o = pose.position, pose.orientation
    moving = twist or wire.Twist()
    v, w = moving.linear, moving.angular
    return BodyState((p.x, p.y, p.z), quaternion(o.roll, o.pitch, o.yaw), (v.x, v.y, v.z), (w.x, w.y, w.z))


def entity_state(state: BodyState) -> wire.EntityState:
    """The state of a body as it is said."""
    return wire.EntityState(pose=pose_of(state), twist=twist_of(state))


def pose_of(state: BodyState) -> wire.Pose:
    """The pose of a body as it is said."""
    x, y, z = state.position
    roll, pitch, yaw = roll_pitch_yaw(state.orientation)
    return wire.Pose(
        position=wire.Vector3(x=x, y=y, z=z), orientation=wire.Orientation(roll=roll, pitch=pitch, yaw=yaw)
    )


def twist_of(state: BodyState) -> wire.Twist:
    """The twist of a body as it is said."""
    vx, vy, vz = state.linear
    wx, wy, wz = state.angular
    return wire.Twist(linear=wire.Vector3(x=vx, y=vy, z=vz), angular=wire.Vector3(x=wx, y=wy, z=wz))


def bounds_of(*corners: Sequence[float]) -> wire.Bounds:
    """A box by its lower and its upper corner, as it is said."""
    lower, upper = (wire.Vector3(x=x, y=y, z=z) for x, y, z in corners)
    return wire.Bounds(lower=lower, upper=upper)


def flat_pose(pose: Pose2) -> wire.Pose:
    """A pose in the plane as it is said."""
    return wire.Pose(position=wire.Vector3(x=pose.x, y=pose.y), orientation=wire.Orientation(yaw=pose.yaw))


def contact_message(time: float, pair: Pair, strike: Strike, *, pushes: bool = False) -> wire.Contact:
    """A contact of two entities at a time [s]."""
    first, second = pair
    where = strike.position
    return wire.Contact(
        time=time,
        first=first,
        second=second,
        strikers=strike.strikers,
        position=None if where is None else wire.Vector3(x=where[0], y=where[1], z=where[2]),
        held=dict(strike.held),
        pushes=pushes,
    )


def feedback_message(robot: str, time: float, feedback: Feedback) -> wire.NavigationFeedback:
    """How far a robot is at a time [s], as it is said."""
    return wire.NavigationFeedback(robot=robot, time=time, **asdict(feedback))

"""Conversions between messages of the wire and types of the simulation."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import asdict

import numpy as np

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.geometry import Pose2, quaternion, roll_pitch_yaw
from sim_nodes.navigation.goals import Feedback
from sim_nodes.physics import BodyState
from sim_nodes.sensors.base import Bumps, Inertial, Odometer
from sim_nodes.sensors.gps import Fix
from sim_nodes.sensors.imaging import DepthFrame, Segments
from sim_nodes.sensors.lidar import Scan
from sim_nodes.sensors.load import Wrench
from sim_nodes.sensors.ranging import Cloud, Echo
from sim_nodes.sensors.sensor_pipeline import Sample
from sim_nodes.strikes import JudgedContact, Pair

FARTHEST = 1000.0  # [m]


def planar(pose: wire.Pose3D) -> Pose2:
    """Project a pose onto the floor.

    Raises:
        RequestRefused: The pose is invalid.
    """
    check_pose(pose, wire.Result.OPERATION_FAILED)
    return Pose2(pose.position.x, pose.position.y, pose.orientation.yaw)


def check_pose(pose: wire.Pose3D, code: int) -> None:
    """Refuse poses that are not finite or too far away."""
    position, orientation = pose.position, pose.orientation
    place = (position.x, position.y, position.z)
    angles = (orientation.roll, orientation.pitch, orientation.yaw)
    if not all(math.isfinite(value) for value in place + angles) or max(abs(value) for value in place) > FARTHEST:
        raise RequestRefused(code, f"invalid pose {place}, {angles}; expected numbers within {FARTHEST:.0f} m")


def body_state(pose: wire.Pose3D, twist: wire.Twist | None = None) -> BodyState:
    """Return the state of a body at a pose; at rest without a twist."""
    p, o = pose.position, pose.orientation
    moving = twist or wire.Twist()
    v, w = moving.linear, moving.angular
    return BodyState((p.x, p.y, p.z), quaternion(o.roll, o.pitch, o.yaw), (v.x, v.y, v.z), (w.x, w.y, w.z))


def entity_state(state: BodyState) -> wire.EntityState:
    """Convert the state of a body to a message."""
    twist = wire.Twist(linear=vector3(state.linear), angular=vector3(state.angular))
    return wire.EntityState(pose=pose_of(state), twist=twist)


def pose_of(state: BodyState) -> wire.Pose3D:
    """Convert the pose of a body to a message."""
    roll, pitch, yaw = roll_pitch_yaw(state.orientation)
    return wire.Pose3D(wire.Position3D(*state.position), wire.Orientation3D(roll, pitch, yaw))


def vector3(values: Sequence[float]) -> wire.Vector3:
    """Convert a vector to a message."""
    x, y, z = values
    return wire.Vector3(x=x, y=y, z=z)


def bounds_of(*corners: Sequence[float]) -> wire.Bounds:
    """Convert the lower and upper corner of a box to a message."""
    lower, upper = (wire.Position3D(*corner) for corner in corners)
    return wire.Bounds(lower=lower, upper=upper)


def flat_pose(pose: Pose2) -> wire.Pose3D:
    """Convert a pose in the plane to a message."""
    return wire.Pose3D(wire.Position3D(pose.x, pose.y), wire.Orientation3D(yaw=pose.yaw))


def contact_message(time: float, pair: Pair, strike: JudgedContact, *, pushes: bool = False) -> wire.Contact:
    """Return the message of a contact between two entities at a time [s]."""
    first, second = pair
    return wire.Contact(
        time=time,
        first=first,
        second=second,
        strikers=strike.strikers,
        position=None if strike.position is None else wire.Position3D(*strike.position),
        held=dict(strike.held),
        pushes=pushes,
    )


def feedback_message(robot: str, time: float, feedback: Feedback) -> wire.NavigationFeedback:
    """Return the message of a robot's navigation feedback at a time [s]."""
    return wire.NavigationFeedback(robot=robot, time=time, **asdict(feedback))


def cloud_message(cloud: Cloud) -> wire.PointCloud:
    """Convert a scan of a 3D lidar to a message; beams without a return have no number (NaN)."""
    hit = np.isfinite(cloud.ranges)
    points = np.where(hit, cloud.ranges, np.nan)[:, None] * cloud.directions
    beams = len(points) // cloud.rings
    return wire.PointCloud(rings=cloud.rings, beams=beams, points=points.astype("<f4").tobytes())


def depth_message(frame: DepthFrame) -> wire.DepthSample:
    """Convert an image of a depth camera to a message."""
    height, width = frame.depths.shape
    picture = b"" if frame.picture is None else frame.picture.tobytes()
    return wire.DepthSample(
        width=width, height=height, depths=frame.depths.astype("<f4").tobytes(), picture=picture
    )


def segmentation_message(segments: Segments) -> wire.SegmentationSample:
    """Convert an image of a segmentation sensor to a message."""
    return wire.SegmentationSample(
        width=segments.width,
        height=segments.height,
        labels=segments.labels,
        names=segments.names,
        seen=tuple(wire.SeenEntity(**asdict(box)) for box in segments.boxes),
    )


def sample_message(sample: Sample[object], time_of_tick: Callable[[int], float]) -> wire.SensorSample:
    """Convert a sample to a message.

    Args:
        sample: The sample.
        time_of_tick: Returns the time of a tick [s].
    """
    time = time_of_tick(sample.tick)
    match sample.data:
        case Scan(ranges=ranges, angles=angles):
            scan = wire.LaserScan(ranges=tuple(ranges.tolist()), bearings=tuple(angles.tolist()))
            return wire.SensorSample(time=time, lidar=scan)
        case Odometer(pose=pose, travelled=travelled, velocity=velocity):
            odometry = wire.OdometrySample(
                pose=flat_pose(pose),
                travelled=travelled,
                linear=velocity.linear,
                angular=velocity.angular,
                lateral=velocity.lateral,
            )
            return wire.SensorSample(time=time, odometry=odometry)
        case Inertial(acceleration=acceleration, angular_rate=rate):
            imu = wire.ImuSample(acceleration=vector3(acceleration.tolist()), angular_rate=vector3(rate.tolist()))
            return wire.SensorSample(time=time, imu=imu)
        case Cloud():
            return wire.SensorSample(time=time, cloud=cloud_message(sample.data))
        case Echo(distance=distance):
            return wire.SensorSample(time=time, echo=wire.RangeSample(range=distance))
        case DepthFrame():
            return wire.SensorSample(time=time, depth=depth_message(sample.data))
        case Segments():
            return wire.SensorSample(time=time, segmentation=segmentation_message(sample.data))
        case Wrench(force=force, torque=torque):
            wrench = wire.WrenchSample(force=vector3(force.tolist()), torque=vector3(torque.tolist()))
            return wire.SensorSample(time=time, wrench=wrench)
        case Fix(point=point):
            fix = wire.NavSatFix(
                latitude=math.degrees(point.latitude),
                longitude=math.degrees(point.longitude),
                altitude=point.altitude,
            )
            return wire.SensorSample(time=time, fix=fix)
        case Bumps(bumps=bumps):
            pressed = (
                wire.Bump(zone=bump.zone, entity=bump.entity, since=time_of_tick(bump.since)) for bump in bumps
            )
            return wire.SensorSample(time=time, bumper=wire.BumperSample(bumps=tuple(pressed)))
        case _:
            raise AssertionError(f"unsupported sample {type(sample.data).__name__}")

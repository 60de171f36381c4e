"""Data that a simulator publishes while time passes: see `seoro.bridges.wire.streams`.

Streams belong to the simulator and outlast its worlds; data that a world lacks are omitted. They do not affect the
simulation, and cost nothing while none is open.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import suppress
from typing import Protocol

import numpy as np

from seoro.bridges import wire
from seoro.bridges.session import SessionError
from seoro.deferred import dataclass
from sim_nodes.geometry import Array
from sim_nodes.messages import flat_pose, sample_message
from sim_nodes.outcomes import feature_unsupported, operation_failed, unknown
from sim_nodes.robots.kinematics import motor_joints
from sim_nodes.robots.robot import Robot
from sim_nodes.sensors.description import CAMERA_RATE
from sim_nodes.sensors.sensor_pipeline import Sample
from sim_nodes.ticks import TICK
from sim_nodes.views import Picture
from sim_nodes.watches import Watched

MAX_STREAMS = 16
BATTERY_TICKS = 50  # between two battery states
POSE_TICKS = 5  # between two poses of a robot, at the rate of its lidar
PICTURE_TICKS = round(1.0 / CAMERA_RATE / TICK)
SUBSCRIBER_CHECK_TICKS = 50  # between two checks for subscribers


class StreamPublisher(Protocol):
    """Publisher of a stream."""

    def put(self, payload: bytes) -> None:
        """Publish without blocking."""

    @property
    def has_subscribers(self) -> bool:
        """Whether the stream has subscribers."""

    def close(self) -> None:
        """Stop publishing."""


ConnectStream = Callable[[str], StreamPublisher]
"""Returns the publisher of a stream by name.

Raises:
    ValueError: The name is invalid.
"""


class StreamSource(Watched, Protocol):
    """The simulation as seen by streams."""

    @property
    def robots(self) -> Mapping[str, Robot]:
        """Robots by name."""

    def robot(self, name: str) -> Robot:
        """Return a robot by name.

        Raises:
            RequestRefused: The robot is unknown.
        """

    def time_of_tick(self, tick: int) -> float:
        """Return the time of a tick [s]."""

    def check_camera(self, name: str) -> None:
        """Refuse cameras that are unknown or cannot be rendered.

        Raises:
            RequestRefused: The message names the reason.
        """

    def picture(self, camera: str) -> Sample[Picture] | None:
        """Return the present picture of a camera; None if it is unknown or gives none."""


@dataclass
class _Stream:
    request: wire.OpenStream
    publisher: StreamPublisher
    number: int = 0
    had_subscribers: bool = False

    @property
    def is_over(self) -> bool:
        """Whether all subscribers have gone."""
        return self.had_subscribers and not self.publisher.has_subscribers

    def publish(self, simulation: StreamSource) -> None:
        self.number += 1
        if self.publisher.has_subscribers:
            self.had_subscribers = True
            with suppress(SessionError):  # subscribers open the stream again on the next session
                self.publisher.put(wire.encode(self._update(simulation)))

    def _update(self, simulation: StreamSource) -> wire.StreamUpdate:
        robots, tick = simulation.robots, simulation.tick
        return wire.StreamUpdate(
            number=self.number,
            time=simulation.time_of_tick(tick),
            samples=tuple(self._samples(simulation)),
            poses=tuple(self._poses(robots)) if tick % POSE_TICKS == 0 else (),
            joints=tuple(_joints(robots[name]) for name in self.request.joints if name in robots),
            batteries=tuple(self._batteries(robots)) if tick % BATTERY_TICKS == 0 else (),
            pictures=tuple(self._pictures(simulation)) if tick % PICTURE_TICKS == 0 else (),
        )

    def _pictures(self, simulation: StreamSource) -> Iterator[wire.StreamedPicture]:
        for name in self.request.cameras:
            given = simulation.picture(name)
            if given is not None:
                height, width, _ = given.data.shape
                yield wire.StreamedPicture(
                    camera=name,
                    time=simulation.time_of_tick(given.tick),
                    width=width,
                    height=height,
                    pixels=given.data.tobytes(),
                )

    def _samples(self, simulation: StreamSource) -> Iterator[wire.StreamedSample]:
        robots = simulation.robots
        for each in self.request.sensors:
            pipeline = robots[each.robot].sensors.get(each.sensor) if each.robot in robots else None
            if pipeline is not None and pipeline.arrived is not None:
                sample = sample_message(pipeline.arrived, simulation.time_of_tick)
                yield wire.StreamedSample(robot=each.robot, sensor=each.sensor, sample=sample)

    def _poses(self, robots: Mapping[str, Robot]) -> Iterator[wire.StreamedPose]:
        for name in self.request.poses:
            if name not in robots or not robots[name].drives:
                continue
            mobile = robots[name].mobile
            base, odom, deviation = mobile.localised_pose(), mobile.localisation.map_to_odom(), mobile.deviation()
            if base is not None and odom is not None and deviation is not None:
                yield wire.StreamedPose(
                    robot=name, base=flat_pose(base), odom=flat_pose(odom), deviation=deviation
                )

    def _batteries(self, robots: Mapping[str, Robot]) -> Iterator[wire.StreamedBattery]:
        for name in self.request.batteries:
            charge = robots[name].mobile.charge if name in robots and robots[name].drives else None
            if charge is not None:
                yield wire.StreamedBattery(robot=name, charge=charge)


class Streams:
    """The streams of a simulator."""

    def __init__(self) -> None:
        self._connect: ConnectStream | None = None
        self._streams: dict[str, _Stream] = {}
        self._robots: Mapping[str, Robot] = {}  # of the present world

    def connect(self, connect: ConnectStream) -> None:
        """Set the factory of publishers; before that, streams are refused."""
        self._connect = connect

    @property
    def are_open(self) -> bool:
        """Whether there are any; they need every tick."""
        return bool(self._streams)

    def open(self, request: wire.OpenStream, simulation: StreamSource) -> None:
        """Open a stream.

        Raises:
            RequestRefused: The name is invalid or in use, a robot, sensor or camera is unknown, or cannot render.
        """
        if self._connect is None:
            raise feature_unsupported("this simulator does not publish streams")
        if request.id in self._streams:
            raise operation_failed(f"duplicate stream {request.id!r}")
        if len(self._streams) >= MAX_STREAMS:
            raise operation_failed(f"too many streams: {MAX_STREAMS} at most; close some")
        for each in request.sensors:
            simulation.pipeline(each.robot, each.sensor).sensor.check()
        for camera in request.cameras:
            simulation.check_camera(camera)
        for name in (*request.poses, *request.joints, *request.batteries):
            simulation.robot(name)
        try:
            publisher = self._connect(request.id)
        except ValueError as error:
            raise operation_failed(str(error)) from error
        self._streams[request.id] = _Stream(request, publisher)
        self.activate_sensors(simulation.robots)

    def close(self, name: str) -> None:
        """Close a stream.

        Raises:
            RequestRefused: The stream is unknown.
        """
        if name not in self._streams:
            raise unknown(f"stream {name!r}", "open streams", self._streams)
        self._streams.pop(name).publisher.close()
        self.activate_sensors(self._robots)

    def activate_sensors(self, robots: Mapping[str, Robot]) -> None:
        """Activate the sensors of open streams, and no others, of the robots of the present world."""
        self._robots = robots
        wanted = {
            (each.robot, each.sensor) for stream in self._streams.values() for each in stream.request.sensors
        }
        for name, robot in robots.items():
            for sensor, pipeline in robot.sensors.items():
                pipeline.is_streamed = (name, sensor) in wanted

    def tick(self, simulation: StreamSource) -> None:
        """Publish the data of a tick."""
        if simulation.tick % SUBSCRIBER_CHECK_TICKS == 0:
            for name in [name for name, stream in self._streams.items() if stream.is_over]:
                self.close(name)
        for stream in self._streams.values():
            stream.publish(simulation)


def _joints(robot: Robot) -> wire.StreamedJoints:
    """Return the joints of a robot's arm, gripper and wheels."""
    names: list[str] = []
    columns: list[Array] = [np.zeros((3, 0))]
    if robot.declaration.arm is not None:
        states = robot.arm.states()
        names += robot.arm.joints
        columns.append(np.array([states.positions, states.velocities, states.efforts]))
    if robot.declaration.mobile is not None:
        motors, wheels = motor_joints(robot.declaration.mobile.drive), robot.mobile.wheels
        names += motors
        still = (0.0,) * len(motors)
        turning = (*wheels.turning, *still[len(wheels.turning) :])
        columns.append(np.array([wheels.encoders(), turning, still]))
    positions, velocities, efforts = np.hstack(columns).tolist()
    joints = wire.JointStates(names=names, positions=positions, velocities=velocities, efforts=efforts)
    return wire.StreamedJoints(robot=robot.name, joints=joints)

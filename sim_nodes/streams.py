"""What a simulator publishes by itself while time passes: see `seoro.bridges.wire.streams`.

Streams belong to the simulator and outlast its worlds; what a world does not have is not published. They change
nothing of what is simulated, and without any, a tick is as fast as ever.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any, Protocol

import numpy as np

from seoro.bridges import wire
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes.geometry import Array
from sim_nodes.messages import flat_pose
from sim_nodes.robots.robot import Robot
from sim_nodes.samples import sample_message
from sim_nodes.sensors.feed import Feed

MAX_STREAMS = 16
BATTERY_TICKS = 50  # between two charges of a battery
POSE_TICKS = 5  # between two poses of a robot, as often as its lidar turns
LOOK_TICKS = 50  # between two looks at whether a stream is taken


class Outlet(Protocol):
    """Where a stream goes to."""

    def put(self, payload: bytes) -> None:
        """Publish, without waiting for anybody."""
        ...

    @property
    def is_taken(self) -> bool:
        """Whether somebody subscribes."""
        ...

    def close(self) -> None:
        """Publish nothing any more."""
        ...


Connect = Callable[[str], Outlet]
"""Makes the outlet of a stream by its name.

Raises:
    ValueError: Streams cannot be called that.
"""


class Told(Protocol):
    """What streams see of a simulation."""

    @property
    def tick(self) -> int:
        """The last tick."""
        ...

    @property
    def robots(self) -> Mapping[str, Robot]:
        """The robots by their names."""
        ...

    def robot(self, name: str) -> Robot:
        """A robot by name.

        Raises:
            RequestRefused: There is none.
        """
        ...

    def feed(self, robot: str, sensor: str) -> Feed[Any]:
        """The way of the samples of a robot's sensor.

        Raises:
            RequestRefused: There is no such robot or sensor.
        """
        ...

    def time_of_tick(self, tick: int) -> float:
        """The time of a tick [s]."""
        ...


@dataclass
class _Stream:
    wanted: wire.OpenStream
    outlet: Outlet
    number: int = 0
    was_taken: bool = False

    @property
    def is_over(self) -> bool:
        """Whether those who took it have gone."""
        return self.was_taken and not self.outlet.is_taken

    def publish(self, simulation: Told) -> None:
        self.number += 1
        if self.outlet.is_taken:
            self.was_taken = True
            self.outlet.put(wire.encode(self._told(simulation)))

    def _told(self, simulation: Told) -> wire.Streamed:
        robots, tick = simulation.robots, simulation.tick
        return wire.Streamed(
            number=self.number,
            time=simulation.time_of_tick(tick),
            samples=tuple(self._samples(simulation)),
            poses=tuple(self._poses(robots)) if tick % POSE_TICKS == 0 else (),
            joints=tuple(_joints(robots[name]) for name in self.wanted.joints if name in robots),
            batteries=tuple(self._batteries(robots)) if tick % BATTERY_TICKS == 0 else (),
        )

    def _samples(self, simulation: Told) -> Iterator[wire.StreamedSample]:
        robots = simulation.robots
        for each in self.wanted.sensors:
            feed = robots[each.robot].sensors.get(each.sensor) if each.robot in robots else None
            if feed is not None and feed.arrived is not None:
                sample = sample_message(feed.arrived, simulation.time_of_tick)
                yield wire.StreamedSample(robot=each.robot, sensor=each.sensor, sample=sample)

    def _poses(self, robots: Mapping[str, Robot]) -> Iterator[wire.StreamedPose]:
        for name in self.wanted.poses:
            if name not in robots or not robots[name].drives:
                continue
            mobile = robots[name].mobile
            base, odom, deviation = mobile.localised_pose(), mobile.map_to_odom(), mobile.deviation()
            if base is not None and odom is not None and deviation is not None:
                yield wire.StreamedPose(
                    robot=name, base=flat_pose(base), odom=flat_pose(odom), deviation=deviation
                )

    def _batteries(self, robots: Mapping[str, Robot]) -> Iterator[wire.StreamedBattery]:
        for name in self.wanted.batteries:
            charge = robots[name].mobile.charge if name in robots and robots[name].drives else None
            if charge is not None:
                yield wire.StreamedBattery(robot=name, charge=charge)


class Streams:
    """The streams of a simulator."""

    def __init__(self) -> None:
        self._connect: Connect | None = None
        self._streams: dict[str, _Stream] = {}

    def connect(self, connect: Connect) -> None:
        """Say how outlets are made; before that, streams are refused."""
        self._connect = connect

    @property
    def are_open(self) -> bool:
        """Whether there are any, which need every tick."""
        return bool(self._streams)

    def open(self, request: wire.OpenStream, simulation: Told) -> None:
        """Open a stream.

        Raises:
            RequestRefused: The name is taken or cannot be used, or there are no such robots or sensors.
        """
        if self._connect is None:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, "this simulator publishes nothing")
        if request.id in self._streams:
            raise RequestRefused(Result.OPERATION_FAILED, f"there is a stream {request.id!r} already")
        if len(self._streams) >= MAX_STREAMS:
            raise RequestRefused(Result.OPERATION_FAILED, f"there are {MAX_STREAMS} streams already: close some")
        for each in request.sensors:
            simulation.feed(each.robot, each.sensor)
        for name in (*request.poses, *request.joints, *request.batteries):
            simulation.robot(name)
        try:
            outlet = self._connect(request.id)
        except ValueError as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error
        self._streams[request.id] = _Stream(request, outlet)
        self.use(simulation.robots)

    def close(self, name: str) -> None:
        """Close a stream.

        Raises:
            RequestRefused: There is none of that name.
        """
        if name not in self._streams:
            raise RequestRefused(
                Result.NOT_FOUND, f"there is no stream {name!r}: open are {listed(self._streams)}"
            )
        self._streams.pop(name).outlet.close()

    def use(self, robots: Mapping[str, Robot]) -> None:
        """Have the robots sense what is to be published."""
        for stream in self._streams.values():
            for each in stream.wanted.sensors:
                feed = robots[each.robot].sensors.get(each.sensor) if each.robot in robots else None
                if feed is not None:
                    feed.in_use = True

    def tick(self, simulation: Told) -> None:
        """Publish what there is in a tick."""
        if simulation.tick % LOOK_TICKS == 0:
            for name in [name for name, stream in self._streams.items() if stream.is_over]:
                self.close(name)
        for stream in self._streams.values():
            stream.publish(simulation)


def _joints(robot: Robot) -> wire.StreamedJoints:
    """The joints of a robot's arm and gripper, and its wheels."""
    names: list[str] = []
    columns: list[Array] = [np.zeros((3, 0))]
    if robot.declaration.arm is not None:
        states = robot.arm.states()
        names += robot.arm.joints
        columns.append(np.array([states.positions, states.velocities, states.efforts]))
    if robot.declaration.mobile is not None:
        drive, wheels = robot.declaration.mobile.drive, robot.mobile.wheels
        names += (drive.left_joint, drive.right_joint)
        columns.append(np.array([wheels.encoders(), wheels.turning, (0.0, 0.0)]))
    positions, velocities, efforts = np.hstack(columns).tolist()
    joints = wire.JointStates(names=names, positions=positions, velocities=velocities, efforts=efforts)
    return wire.StreamedJoints(robot=robot.name, joints=joints)

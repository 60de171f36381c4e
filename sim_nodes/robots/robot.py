"""Robots in a simulation: the parts of a robot, and their updates."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any, NamedTuple

from sim_nodes.cameras import Cameras
from sim_nodes.entities import Entities
from sim_nodes.faults.actuators import GRIPPER, JOINTS, Actuator, ArmActuator, WheelMotors
from sim_nodes.faults.devices import CameraDevice, Device, SensorDevice, Source
from sim_nodes.faults.registry import FaultRegistry, RobotPower
from sim_nodes.geodesy import GeoPoint
from sim_nodes.manipulation.arm import Arm
from sim_nodes.noise import Noise
from sim_nodes.outcomes import GoalResult, feature_unsupported
from sim_nodes.physics import BodyState, Engine, PlacedRobot
from sim_nodes.robots.mobile import MobileBase
from sim_nodes.sensors.base import Bumper
from sim_nodes.sensors.mounted import mounted_sensors
from sim_nodes.sensors.sensor_pipeline import SensorPipeline
from sim_nodes.stateful import Stateful
from sim_nodes.terrain.surface import Surface


class Sample(NamedTuple):
    """Motion of an entity in a tick: state of its base, and positions and velocities of its joints [rad, m]."""

    tick: int
    base: BodyState
    joints: tuple[float, ...] = ()
    rates: tuple[float, ...] = ()


class Robot(Stateful):
    """A robot of the world.

    Args:
        placed: Name, kind and initial pose.
        engine: Engine that simulates it.
        entities: Entities of the world.
        surface: Ground and map of the world.
        seed: Seed of the simulation.
        origin: Place of the world on the earth, if declared.

    Attributes:
        drives: Whether it has a wheeled base.
    """

    STATE = ("_mobile", "_arm", "_mounted", "faults")

    def __init__(
        self,
        placed: PlacedRobot,
        engine: Engine,
        entities: Entities,
        surface: Surface,
        seed: int,
        origin: GeoPoint | None,
    ) -> None:
        self.name = placed.name
        self._engine = engine
        self.declaration = declaration = placed.declaration
        mobile, arm = declaration.mobile, declaration.arm
        self.drives = mobile is not None
        self._mobile = MobileBase(self.name, mobile, engine, surface, seed) if mobile is not None else None
        self._arm = Arm(placed, arm, engine, entities.is_movable) if arm is not None else None
        self._mounted = mounted_sensors(placed, engine, seed, origin)
        self._drives = dict(self._make_actuators(seed))
        self.faults = FaultRegistry(self.name, self._devices(entities.cameras))
        self._moving = tuple(part for part in (self._mobile, self._arm) if part is not None)
        self._parts: tuple[MobileBase | Arm | FaultRegistry, ...] = (*self._moving, self.faults)

    def _devices(self, cameras: Cameras) -> dict[str, Device]:
        """Return the devices that can have faults, by name."""
        sources: dict[str, Source] = {
            name: SensorDevice(name, pipeline) for name, pipeline in self.sensors.items()
        }
        carried = [camera.name for camera in self.declaration.cameras]
        sources |= {name: CameraDevice(name, cameras, f"{self.name}/{name}") for name in carried}
        whole = {"robot": RobotPower(sources, self._drives)} if sources else {}
        return {**sources, **self._drives, **whole}

    def _make_actuators(self, seed: int) -> Iterator[tuple[str, Actuator]]:
        """Yield its actuators by name."""

        def noise(device: str) -> Callable[[str], Noise]:
            return lambda purpose: Noise(seed, f"{self.name}/{device}/{purpose}")

        if self._arm is not None:
            servos = self._arm.servos
            yield "joints", ArmActuator(JOINTS, servos, servos, noise("joints"))
            if self._arm.has_gripper:
                gripper = self._arm.gripper
                yield "gripper", ArmActuator(GRIPPER, gripper, gripper.fingers, noise("gripper"))
        if self._mobile is not None:
            yield "motors", WheelMotors(self._mobile.wheels, self._mobile.motion, noise("motors"))

    @property
    def mobile(self) -> MobileBase:
        """The wheeled base.

        Raises:
            RequestRefused: The robot has none.
        """
        if self._mobile is None:
            raise feature_unsupported(f"{self.name} has no wheeled base")
        return self._mobile

    @property
    def arm(self) -> Arm:
        """The arm, or the position-controlled joints of another body.

        Raises:
            RequestRefused: The robot has none.
        """
        if self._arm is None:
            raise feature_unsupported(f"{self.name} has no arm")
        return self._arm

    @property
    def is_idle(self) -> bool:
        """Whether no part needs every tick."""
        for part in self._moving:
            if not part.is_idle:
                return False
        if self.faults.goals or any(drive.is_busy for drive in self._drives.values()):
            return False
        return not any(pipeline.faults or pipeline.is_active for pipeline in self._mounted.values())

    @property
    def sensors(self) -> Mapping[str, SensorPipeline[Any]]:
        """Pipelines of its sensors by name."""
        return {**(self._mobile.sensors if self._mobile is not None else {}), **self._mounted}

    def update_bumper(self, tick: int) -> None:
        """Update its bumper with the present contacts, before a tick."""
        bumper = self.sensors["bumper"].sensor if "bumper" in self.sensors else None
        if isinstance(bumper, Bumper):
            bumper.touch(self._engine.contact_points(self.name), tick)

    @property
    def rendered_sensors(self) -> tuple[SensorPipeline[Any], ...]:
        """Pipelines of the sensors that render."""
        return tuple(pipeline for pipeline in self._mounted.values() if pipeline.sensor.sample_size)

    @property
    def held(self) -> str | None:
        """Entity held by its gripper, if any."""
        return None if self._arm is None else self._arm.held

    def motion(self, tick: int) -> Sample:
        """Return the present motion."""
        base = self._engine.body_state(self.name)
        if self._arm is None:
            return Sample(tick, base)
        states = self._arm.states()
        return Sample(tick, base, tuple(states.positions.tolist()), tuple(states.velocities.tolist()))

    def commanded_motion(self, now: Sample) -> Sample:
        """Return the motion as commanded, as if nothing blocked the wheels."""
        if self._mobile is None:
            return now
        linear, angular, lateral = self._mobile.commanded_velocity()
        yaw = now.base.planar.yaw
        cos, sin = math.cos(yaw), math.sin(yaw)
        ahead = (linear * cos - lateral * sin, linear * sin + lateral * cos, 0.0)
        return now._replace(base=replace(now.base, linear=ahead, angular=(0.0, 0.0, angular)))

    @property
    def truth_frame(self) -> str:
        """Name of the frame of the true pose."""
        return f"{self.name}_base_link_gt"

    @property
    def goals(self) -> tuple[str, ...]:
        """Ids of active goals that a client waits for."""
        return tuple(goal for part in self._parts for goal in part.goals)

    def tick(self, tick: int) -> Sequence[GoalResult]:
        """Update with a tick, after the fleet; returns the results of goals that ended."""
        ended: list[GoalResult] = []
        for part in self._moving:
            ended.extend(part.tick(tick))
        for pipeline in self._mounted.values():
            pipeline.update(tick)
        for drive in self._drives.values():
            drive.update(tick)
        if self.faults.is_busy:
            ended.extend(self.faults.tick(tick))
        return ended

    def cancel(self, goal: str) -> Iterator[GoalResult]:
        """Cancel a goal by id; yields the results."""
        for part in self._parts:
            yield from part.cancel(goal)

    def detach_goals(self, goals: Container[str]) -> None:
        """Continue some goals without their client: results are not reported, and any command replaces them."""
        for part in self._parts:
            part.detach_goals(goals)

    def stop(self) -> Iterator[GoalResult]:
        """Stop every part; yields the results of cancelled goals."""
        for part in self._moving:
            yield from part.stop()

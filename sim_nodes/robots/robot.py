"""A robot in a simulation: the parts that it has, of which each does what is due in a tick."""

from __future__ import annotations

import math
from collections.abc import Callable, Container, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

from seoro.bridges.wire import Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.cameras import Cameras
from sim_nodes.faults.actuators import GRIPPER, JOINTS, Actuators
from sim_nodes.faults.board import FaultBoard
from sim_nodes.faults.cameras import CameraDevice
from sim_nodes.faults.devices import Device, SensorDevice, Source
from sim_nodes.faults.drives import Drive, WheelMotors
from sim_nodes.faults.whole import WholeRobot
from sim_nodes.goals import NOBODY, Ended
from sim_nodes.manipulation.arm import Arm
from sim_nodes.navigation.grid import NavigationMap
from sim_nodes.noise import Noise
from sim_nodes.physics import Engine, PlacedRobot
from sim_nodes.robots.mobile import MobileBase
from sim_nodes.robots.motion import Sample
from sim_nodes.sensors.bumper import Bumper
from sim_nodes.sensors.feed import Feed
from sim_nodes.stateful import Stateful


@dataclass(frozen=True)
class Knowledge:
    """What robots know of the world: its map, which entities can be carried, and its cameras."""

    known: NavigationMap
    is_loose: Callable[[str], bool]
    cameras: Cameras


class Robot(Stateful):
    """A robot of the world.

    Args:
        placed: Its name, kind and place.
        engine: The engine that it is in.
        about: What it knows of the world.
        seed: Seed of the simulation.
    """

    STATE = ("_mobile", "_arm", "faults")

    def __init__(self, placed: PlacedRobot, engine: Engine, about: Knowledge, seed: int) -> None:
        self.name = placed.name
        self._engine = engine
        self.declaration = declaration = placed.declaration
        mobile, arm = declaration.mobile, declaration.arm
        self._mobile = MobileBase(self.name, mobile, engine, about.known, seed) if mobile is not None else None
        self._arm = Arm(placed, arm, engine, seed, about.is_loose) if arm is not None else None
        self._drives = dict(self._made_drives(seed))
        self.faults = FaultBoard(self.name, self._devices(about.cameras))

    def _devices(self, cameras: Cameras) -> dict[str, Device]:
        """What of it can have faults, by names."""
        sources: dict[str, Source] = {name: SensorDevice(name, feed) for name, feed in self.sensors.items()}
        carried = [camera.name for camera in self.declaration.cameras]
        sources |= {name: CameraDevice(name, cameras, f"{self.name}/{name}") for name in carried}
        whole = {"robot": WholeRobot(sources, self._drives)} if sources else {}
        return {**sources, **self._drives, **whole}

    def _made_drives(self, seed: int) -> Iterator[tuple[str, Drive]]:
        """What moves it, by names."""

        def noise(device: str) -> Callable[[str], Noise]:
            return lambda purpose: Noise(seed, f"{self.name}/{device}/{purpose}")

        if self._arm is not None:
            servos, gripper = self._arm.servos, self._arm.gripper
            yield "joints", Actuators(JOINTS, servos, servos, noise("joints"))
            yield "gripper", Actuators(GRIPPER, gripper, gripper.fingers, noise("gripper"))
        if self._mobile is not None:
            yield "motors", WheelMotors(self._mobile.wheels, self._mobile.motion, noise("motors"))

    @property
    def drives(self) -> bool:
        """Whether it has a base that drives."""
        return self._mobile is not None

    @property
    def mobile(self) -> MobileBase:
        """The base that it drives on.

        Raises:
            RequestRefused: It has none.
        """
        if self._mobile is None:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, f"{self.name} is a robot that does not drive")
        return self._mobile

    @property
    def arm(self) -> Arm:
        """Its arm.

        Raises:
            RequestRefused: It has none.
        """
        if self._arm is None:
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, f"{self.name} is a robot without an arm")
        return self._arm

    @property
    def is_idle(self) -> bool:
        """Whether no part of it has to do anything in every tick."""
        base, arm = self._mobile, self._arm
        if any(drive.is_busy for drive in self._drives.values()):
            return False
        return not self.faults.goals and (base is None or base.is_idle) and (arm is None or arm.is_idle)

    @property
    def sensors(self) -> Mapping[str, Feed[Any]]:
        """The ways of its sensors' samples, by the sensors' names."""
        return self._mobile.sensors if self._mobile is not None else {}

    def touch(self, tick: int) -> None:
        """Let its bumper feel what touches it now, before the tick with that number."""
        bumper = self.sensors["bumper"].sensor if "bumper" in self.sensors else None
        if isinstance(bumper, Bumper):
            bumper.touch(self._engine.touch_points(self.name), tick)

    @property
    def held(self) -> str | None:
        """What its gripper holds, if it has one."""
        return None if self._arm is None else self._arm.gripper.held

    def motion(self, tick: int) -> Sample:
        """How it moves now."""
        base = self._engine.body_state(self.name)
        if self._arm is None:
            return Sample(tick, base)
        states = self._arm.states()
        return Sample(tick, base, tuple(states.positions.tolist()), tuple(states.velocities.tolist()))

    def told_motion(self, now: Sample) -> Sample:
        """How it would move if nothing hindered its wheels, given how it moves now."""
        if self._mobile is None:
            return now
        linear, angular = self._mobile.told_velocity()
        yaw = now.base.planar.yaw
        ahead = (linear * math.cos(yaw), linear * math.sin(yaw), 0.0)
        return replace(now, base=replace(now.base, linear=ahead, angular=(0.0, 0.0, angular)))

    @property
    def truth_frame(self) -> str:
        """Name of the frame in which the robot really is."""
        return f"{self.name}_base_link_gt"

    @property
    def goals(self) -> tuple[str, ...]:
        """The ids of the goals that it is working on, for somebody."""
        goal = self._mobile.goal if self._mobile is not None else None
        driving = () if goal in (None, NOBODY) else (goal,)
        moving = () if self._arm is None else self._arm.goals
        return (*driving, *moving, *self.faults.goals)

    def tick(self, tick: int) -> Iterator[Ended]:
        """Do what is due in a tick; gives the goals that ended."""
        if self._mobile is not None:
            ended = self._mobile.tick(tick)
            if ended is not None:
                yield ended
        if self._arm is not None:
            yield from self._arm.tick(tick)
        for drive in self._drives.values():
            drive.pass_tick(tick)
        yield from self.faults.tick(tick)

    def cancel(self, goal: str) -> Iterator[Ended]:
        """Stop what works on a goal, by its id; gives the goals that ended with that."""
        if goal in self.faults.goals:
            yield from self.faults.cancel(goal)
        elif self._arm is not None and goal in self._arm.goals:
            yield from self._arm.cancel(goal)
        elif goal in self.goals:
            yield from self._stop_base()

    def disown(self, goals: Container[str]) -> None:
        """Go on with all goals, but with these for nobody: their ends are not told, and any command ends them."""
        if self._mobile is not None:
            self._mobile.disown(goals)
        if self._arm is not None:
            self._arm.disown(goals)
        self.faults.disown(goals)

    def stop(self) -> Iterator[Ended]:
        """Make every part stand still; gives the goals that ended with that."""
        yield from self._stop_base()
        if self._arm is not None:
            yield from self._arm.stop()

    def _stop_base(self) -> Iterator[Ended]:
        goal = self._mobile.stop() if self._mobile is not None else None
        if goal is not None:
            yield Ended(goal, Outcome.CANCELED)

"""A base that drives: what it senses, where it believes to be, what drives it.

It does something in ticks of simulated time only: odometry every tick, scan, localisation and obstacle
layer at the rate of its lidar, control every `CONTROL_TICKS`. A base that is idle has ticks now and then only.
"""

from __future__ import annotations

import math
from collections.abc import Container
from dataclasses import replace

from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.faults.motors import Motion
from sim_nodes.geometry import Pose2
from sim_nodes.goals import NOBODY, Ended
from sim_nodes.navigation.grid import NavigationMap
from sim_nodes.navigation.localisation import Localisation
from sim_nodes.navigation.navigator import Feedback, Goal, Navigator, Situation
from sim_nodes.navigation.obstacles import ObstacleLayer
from sim_nodes.noise import Noise
from sim_nodes.physics import Engine
from sim_nodes.robots.battery import Battery
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.diff_drive import AT_REST, Velocity, base_motion, wheel_speeds, wheel_ways
from sim_nodes.robots.sensing import base_sensors
from sim_nodes.robots.steering import COMMAND_TIMEOUT, Order, Steering
from sim_nodes.robots.wheels import Wheels
from sim_nodes.sensors.feed import Feed
from sim_nodes.sensors.lidar import Scan
from sim_nodes.sensors.odometry import AT_START, Odometer
from sim_nodes.stateful import Stateful
from sim_nodes.ticks import TICK

CONTROL_TICKS = 2  # 25 Hz


class MobileBase(Stateful):
    """The base of a robot that drives.

    Args:
        name: Name of the robot.
        declaration: What is declared of its base.
        engine: The engine that it is in.
        known: The map of the world.
        seed: Seed of the simulation.

    Attributes:
        wheels: Its wheels.
        sensors: The ways of its sensors' samples, by the sensors' names.
        battery: Its battery, if one is declared.
    """

    STATE = ("wheels", "battery", "sensors", "localisation", "_obstacles", "_navigator", "_steering", "_scan")

    def __init__(
        self, name: str, declaration: MobileDeclaration, engine: Engine, known: NavigationMap, seed: int
    ) -> None:
        self.name = name
        self.declaration = declaration
        self._engine = engine
        self.wheels = Wheels(name, engine)
        self.battery = None if declaration.battery is None else Battery(declaration.battery)
        self.sensors = base_sensors(name, declaration, engine, self.wheels, seed)
        self._lidar: Feed[Scan] = self.sensors["lidar"]
        self._odometry: Feed[Odometer] = self.sensors["odometry"]
        self.localisation = Localisation(known, declaration, Noise(seed, f"{name}/localisation"))
        self._obstacles = ObstacleLayer(known)
        self._navigator = Navigator(known, self._obstacles, declaration, CONTROL_TICKS * TICK)
        self._steering = Steering(declaration.drive)
        self._scan: Scan | None = None

    @property
    def odometry(self) -> Odometer:
        """What has come of odometry last."""
        latest = self._odometry.latest
        return AT_START if latest is None else latest.data

    @property
    def goal(self) -> str | None:
        """The id of the goal that the robot is driving for."""
        return self._navigator.goal.id if self._navigator.goal is not None else self._steering.goal

    @property
    def charge(self) -> float | None:
        """The charge of its battery, from 0 to 1; None without one."""
        return None if self.battery is None else self.battery.charge

    def motion(self) -> Motion:
        """What the wheels do in the present tick."""
        state, drive, arrived = self._engine.body_state(self.name), self.declaration.drive, self._odometry.arrived
        (vx, vy, _), yaw = state.linear, state.planar.yaw
        moved = Velocity(vx * math.cos(yaw) + vy * math.sin(yaw), state.angular[2])
        return Motion(
            told=self.wheels.told,
            turning=self.wheels.turning,
            counted=None if arrived is None else wheel_ways(drive, arrived.data.velocity),
            moved=wheel_ways(drive, moved),
        )

    def told_velocity(self) -> Velocity:
        """The velocity that its motors were told last."""
        return Velocity(*base_motion(self.declaration.drive, *self.wheels.told))

    @property
    def is_idle(self) -> bool:
        """Whether it neither drives nor localises itself, and nobody uses its sensors."""
        return (
            self.goal is None
            and self._steering.order is None
            and not self.localisation.running
            and not any(feed.faults or feed.in_use for feed in self.sensors.values())
        )

    def localised_pose(self) -> Pose2 | None:
        """The pose in the map as the robot believes it, None until it has an initial pose."""
        return self.localisation.pose(self.odometry.pose)

    def map_to_odom(self) -> Pose2 | None:
        """The pose of the robot's `odom` in the map, None until it has an initial pose."""
        return self.localisation.map_to_odom()

    def deviation(self) -> float | None:
        """Standard deviation of the position that the localisation states [m], None as long as it has no pose."""
        estimate = self.localisation.estimate
        return None if estimate is None else estimate.deviation

    @property
    def recoveries(self) -> int:
        """How often it has recovered, on its way to any goal."""
        return self._navigator.recoveries

    def feedback_due(self) -> Feedback | None:
        """How far it is on its way, where it is time to say so."""
        return self.feedback() if self._navigator.feedback_due() else None

    def feedback(self) -> Feedback:
        """How far it is on its way.

        Raises:
            RequestRefused: It is on no way.
        """
        pose = self.localised_pose()
        if pose is None or self._navigator.goal is None:
            raise RequestRefused(Result.INCORRECT_STATE, f"{self.name} is not on its way to a goal")
        return self._navigator.feedback(pose)

    def tick(self, tick: int) -> Ended | None:
        """Do what is due in a tick; returns the goal that ended."""
        if self.battery is not None:
            self.battery.pass_tick(tick, drives=any(self.wheels.told))
        self.wheels.pass_tick(tick)
        self._lidar.in_use |= self.localisation.running
        for feed in self.sensors.values():
            feed.pass_tick(tick)
        ended = self._steer(tick) if self._steering.order is not None else None
        if self.localisation.running and self._lidar.arrived is not None:
            self._take_in(self._lidar.arrived.data, tick)
        pose = self.localised_pose()
        if self._navigator.goal is None or self._scan is None or pose is None or tick % CONTROL_TICKS:
            return ended
        velocity, ended = self._navigator.control(Situation(pose, self.odometry.velocity, self._scan))
        self._command(velocity)
        return ended

    def _take_in(self, scan: Scan, tick: int) -> None:
        """Make of a scan what can be made of it."""
        self._scan = scan
        self.localisation.update(self.odometry.pose, scan, tick)
        pose = self.localised_pose()
        if pose is not None:
            self._obstacles.update(pose, scan)

    def set_initial_pose(self, pose: Pose2, tick: int) -> None:
        """Tell the localisation where the robot is in the map."""
        self.localisation.set_initial_pose(pose, self.odometry.pose, tick)
        self._obstacles.clear()
        self._scan = None

    def search_pose(self, tick: int) -> None:
        """Forget where the robot is, and look for it on the whole map.

        Raises:
            RequestRefused: It is on its way to a goal, which it can find only while it knows where it is.
        """
        if self._navigator.goal is not None:
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"{self.name} is driving to goal {self.goal!r}: cancel it before the robot forgets where it is",
            )
        self.localisation.search(self.odometry.pose, tick)
        self._obstacles.clear()
        self._scan = None

    def navigate(self, goal: Goal) -> None:
        """Take up a goal. What the robot does for nobody ends, or is taken over if it is the same.

        Raises:
            RequestRefused: Not localised, busy, or the goal is impossible on the map.
        """
        pose = self.localised_pose()
        if pose is None:
            raise RequestRefused(
                Result.INCORRECT_STATE, f"{self.name} does not know where it is: set its initial pose first"
            )
        self._check_free()
        present = self._navigator.goal
        if present is not None and replace(present, id=goal.id) == goal:
            self._navigator.goal = goal
            return
        self._navigator.check(goal.poses, pose)
        self._steering.drop()
        self._navigator.start(goal, pose)

    def _check_free(self) -> None:
        if self.goal not in (None, NOBODY):
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"{self.name} is driving to goal {self.goal!r}: cancel it, or wait for its end",
            )

    def drive(self, goal: str, velocity: Velocity, last: int) -> None:
        """Drive with a velocity until a tick, as a goal.

        Raises:
            RequestRefused: Busy, or the robot cannot be that fast.
        """
        self._check_free()
        self._steering.check(self.name, velocity)
        self._navigator.cancel()
        self._steering.follow(Order(velocity, last, goal))

    def command(self, velocity: Velocity, tick: int) -> None:
        """Drive with a velocity until the next command, for `COMMAND_TIMEOUT` at most.

        Raises:
            RequestRefused: Busy, or the robot cannot be that fast.
        """
        self._check_free()
        self._steering.check(self.name, velocity)
        self._navigator.cancel()
        self._steering.follow(Order(velocity, tick + round(COMMAND_TIMEOUT / TICK), None))

    def _steer(self, tick: int) -> Ended | None:
        velocity, ended = self._steering.control(tick)
        self._command(velocity)
        return ended

    def disown(self, goals: Container[str]) -> None:
        """See `Robot.disown`."""
        goal = self._navigator.goal
        if goal is not None and goal.id in goals:
            self._navigator.goal = replace(goal, id=NOBODY)
        order = self._steering.order
        if order is not None and order.goal is not None and order.goal in goals:
            self._steering.follow(replace(order, goal=NOBODY))

    def stop(self) -> str | None:
        """Drop the goal and stop the wheels; returns the id of the goal there was."""
        goal = self.goal
        self._command(AT_REST)
        self._steering.drop()
        self._navigator.cancel()
        return goal

    def _command(self, velocity: Velocity) -> None:
        self.wheels.turn(*wheel_speeds(self.declaration.drive, velocity))

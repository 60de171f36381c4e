"""A wheeled base: sensors, localisation, navigation and wheels.

It is updated in ticks of simulated time: odometry in every tick; scans at the rate of its lidar. Localisation,
obstacle layer and navigation are updated for all bases together (`fleet.py`). An idle base is updated less often.
"""

from __future__ import annotations

import math
from collections.abc import Container, Iterator, Sequence
from dataclasses import replace

from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.faults.motor_checks import Motion
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.contracts import ControlInput
from sim_nodes.navigation.goals import Feedback, Goal
from sim_nodes.navigation.localisation import Localisation
from sim_nodes.navigation.navigator import Navigator
from sim_nodes.navigation.obstacles import ObstacleLayer
from sim_nodes.navigation.touches import touched_places
from sim_nodes.noise import Noise
from sim_nodes.outcomes import NO_CLIENT, GoalResult, feature_unsupported, incorrect_state
from sim_nodes.physics import Engine
from sim_nodes.robots.base_sensors import base_sensors
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.drive import Battery, Steering, VelocityCommand, Wheels
from sim_nodes.robots.kinematics import AT_REST, Velocity, base_motion, motor_commands, side_speeds
from sim_nodes.robots.path_following import PathFollower
from sim_nodes.sensors.base import AT_START, Bumps, Odometer
from sim_nodes.sensors.lidar import BLIND, Lidar, Scan
from sim_nodes.sensors.sensor_pipeline import SensorPipeline
from sim_nodes.stateful import Stateful
from sim_nodes.terrain.surface import Surface


class MobileBase(Stateful):
    """The wheeled base of a robot.

    Args:
        name: Name of the robot.
        declaration: Declaration of the base.
        engine: Engine that simulates it.
        surface: Ground and map of the world.
        seed: Seed of the simulation.

    Raises:
        RequestRefused: Its planner or controller is unknown or invalid.

    Attributes:
        wheels: Its wheels.
        sensors: Pipelines of its sensors by name.
        battery: Its battery, if declared.
        localisation: Its localisation.
        obstacles: Its obstacle layer.
        navigator: Its navigation.
    """

    STATE = (
        "wheels",
        "battery",
        "sensors",
        "localisation",
        "obstacles",
        "navigator",
        "_steering",
        "_follower",
        "_commanded",
        "_scan",
    )

    def __init__(
        self, name: str, declaration: MobileDeclaration, engine: Engine, surface: Surface, seed: int
    ) -> None:
        self.name = name
        self.declaration = declaration
        self._engine = engine
        self.wheels = Wheels(name, declaration.drive, engine)
        self.battery = None if declaration.battery is None else Battery(declaration.battery)
        self.sensors = base_sensors(name, declaration, engine, self.wheels, seed)
        self._lidar: SensorPipeline[Scan] | None = self.sensors.get("lidar")
        self._odometry: SensorPipeline[Odometer] = self.sensors["odometry"]
        self._bumper: SensorPipeline[Bumps] | None = self.sensors.get("bumper")
        lidar, passable = declaration.lidar, surface.passable(declaration)
        self._without_ground = None if lidar is None else surface.without_ground(name, lidar, engine)
        self.localisation = Localisation(surface.known, declaration, Noise(seed, f"{name}/localisation"))
        self.obstacles = ObstacleLayer(passable)
        try:
            self.navigator = Navigator(passable, self.obstacles, declaration, Noise(seed, f"{name}/navigation"))
        except RequestRefused as refused:
            raise RequestRefused(refused.code, f"robot {name}: {refused.message}") from refused
        self._steering = Steering(declaration.drive)
        self._follower = PathFollower(declaration.drive)
        self._commanded: Velocity | None = None
        self._scan: Scan | None = self._first_scan

    @property
    def _first_scan(self) -> Scan | None:
        """The scan before the first one; without a lidar, that without beams."""
        return BLIND if self._lidar is None else None

    @property
    def odometry(self) -> Odometer:
        """Latest odometry that has arrived."""
        latest = self._odometry.latest
        return AT_START if latest is None else latest.data

    @property
    def goal(self) -> str | None:
        """Id of the active goal."""
        if self._follower.path is not None:
            return self._follower.path.goal
        return self.navigator.goal.id if self.navigator.goal is not None else self._steering.goal

    @property
    def goals(self) -> tuple[str, ...]:
        """Ids of active goals that a client waits for: at most one."""
        return (self.goal,) if self.goal else ()

    @property
    def charge(self) -> float | None:
        """Charge of its battery, from 0 to 1; None without one."""
        return None if self.battery is None else self.battery.charge

    def motion(self) -> Motion:
        """Return the motion of the wheels in the present tick."""
        state, drive, arrived = self._engine.body_state(self.name), self.declaration.drive, self._odometry.arrived
        (vx, vy, _), yaw = state.linear, state.planar.yaw
        moved = Velocity(vx * math.cos(yaw) + vy * math.sin(yaw), state.angular[2])
        return Motion(
            commanded=self.wheels.driven,
            turning=self.wheels.turning,
            odometry=None if arrived is None else side_speeds(drive, arrived.data.velocity),
            actual=side_speeds(drive, moved),
        )

    def commanded_velocity(self) -> Velocity:
        """Return the velocity by the speeds that reach the motors."""
        return base_motion(self.declaration.drive, self.wheels.applied)

    @property
    def is_idle(self) -> bool:
        """Whether it has no motion, no localisation, and no sensor in use."""
        return (
            not self.localisation.running
            and self.goal is None
            and self._steering.command is None
            and not any(pipeline.faults or pipeline.is_active for pipeline in self.sensors.values())
        )

    def localised_pose(self) -> Pose2 | None:
        """Return the localised pose in `map`; None before an initial pose."""
        return self.localisation.pose(self.odometry.pose)

    def deviation(self) -> float | None:
        """Return the standard deviation of the localised position [m]; None without a pose."""
        estimate = self.localisation.estimate
        return None if estimate is None else estimate.deviation

    @property
    def recoveries(self) -> int:
        """Number of recoveries over all goals."""
        return self.navigator.recoveries

    def feedback_due(self) -> Feedback | None:
        """Return the feedback of the active goal, if it is due."""
        return self.feedback() if self.navigator.feedback_due() else None

    def feedback(self) -> Feedback:
        """Return the feedback of the active goal.

        Raises:
            RequestRefused: No goal is active.
        """
        pose = self.localised_pose()
        if pose is None or self.navigator.goal is None:
            raise incorrect_state(f"{self.name} has no active goal")
        return self.navigator.feedback(pose)

    def lidar_due(self, tick: int) -> Lidar | None:
        """Return the lidar if it is read in a tick."""
        pipeline = self._lidar
        if pipeline is None or not isinstance(pipeline.sensor, Lidar):
            return None
        pipeline.in_use = pipeline.in_use or self.localisation.running
        return pipeline.sensor if pipeline.is_due(tick) else None

    def sense(self, tick: int, scan: Scan | None) -> None:
        """Update battery, wheels and sensors with a tick; `scan` is the reading of the lidar if it is due."""
        if self.battery is not None:
            self.battery.update(tick, drives=self.wheels.are_driven)
        self.wheels.update(tick)
        if self._bumper is not None and self.localisation.running:
            self._bumper.in_use = True
        for pipeline in self.sensors.values():
            pipeline.update(tick, scan if pipeline is self._lidar else None)

    def receive_scan(self) -> Scan | None:
        """Return the scan that has arrived in this tick, if localisation and obstacles need it."""
        if self._lidar is None or not self.localisation.running or self._lidar.arrived is None:
            return None
        scan = self._lidar.arrived.data
        self._scan = scan if self._without_ground is None else self._without_ground(scan)
        return self._scan

    @property
    def is_navigating(self) -> bool:
        """Whether it navigates to a goal, and has a scan."""
        return self.navigator.goal is not None and self._scan is not None

    def control_input(self, tick: int) -> ControlInput | None:
        """Return the inputs of a decision of the navigation; None if none is due. It must be navigating."""
        assert self._scan is not None
        pose = self.localised_pose() if tick % self.navigator.period == 0 else None
        if pose is None:
            return None
        places = touched_places(self._bumper, self.declaration, pose)
        if len(places):
            self.obstacles.touch(places)
        hidden = self.obstacles.hidden_points(pose, self._scan)
        velocity, deviation = self.odometry.velocity, self.deviation() or 0.0
        return ControlInput(pose, velocity, self._scan, hidden, len(places) > 0, tick, deviation)

    def follow_navigator(self) -> None:
        """Command the velocity of the navigation for a tick."""
        self._command(self.navigator.velocity())

    def tick(self, tick: int) -> Sequence[GoalResult]:
        """Command a velocity or a path for a tick; returns the result of a goal that ended."""
        ended: GoalResult | None = None
        if self._follower.path is not None:
            ended = self._follow(tick)
        elif self._steering.command is not None:
            velocity, ended = self._steering.control(tick)
            self._command(velocity)
        return () if ended is None else (ended,)

    def _follow(self, tick: int) -> GoalResult | None:
        """Follow a path by the true pose; returns the result of its goal if it ends."""
        wanted, ended = self._follower.control(self._engine.body_state(self.name).planar, tick)
        self._steering.command = VelocityCommand(wanted, tick + 1, None)
        velocity, _ = self._steering.control(tick)
        self._command(velocity)
        if self._follower.path is None:
            self._steering.command = VelocityCommand(AT_REST, tick, None)  # stops at the next tick
        return ended

    def set_initial_pose(self, pose: Pose2, tick: int) -> None:
        """Set the pose of the localisation in `map`."""
        self.localisation.set_initial_pose(pose, self.odometry.pose, tick)
        self.obstacles.clear()
        self._scan = self._first_scan

    def search_pose(self, tick: int) -> None:
        """Start a global search for the pose.

        Raises:
            RequestRefused: The robot has no lidar, or a navigation goal is active, which needs a pose.
        """
        if self._lidar is None:
            raise feature_unsupported(f"{self.name} has no lidar to find its pose by; set its initial pose")
        if self.navigator.goal is not None:
            raise incorrect_state(
                f"{self.name} is busy with goal {self.goal!r}; cancel it before a global localisation"
            )
        self.localisation.search(self.odometry.pose, tick)
        self.obstacles.clear()
        self._scan = self._first_scan

    def navigate(self, goal: Goal) -> None:
        """Accept a navigation goal. A goal without a client is cancelled, or continued if it is equal.

        Raises:
            RequestRefused: The robot is not localised or is busy, or the goal is unreachable on the map.
        """
        pose = self.localised_pose()
        if pose is None:
            raise incorrect_state(f"{self.name} is not localised; set its initial pose first")
        self._check_free()
        present = self.navigator.goal
        if present is not None and replace(present, id=goal.id) == goal:
            self.navigator.goal = goal
            return
        self.navigator.check(goal.poses, pose)
        self._steering.clear()
        self._follower.path = None
        self.navigator.start(goal, pose)

    def _check_free(self) -> None:
        if self.goal not in (None, NO_CLIENT):
            raise incorrect_state(f"{self.name} is busy with goal {self.goal!r}; cancel it or wait for its end")

    def drive(self, command: VelocityCommand) -> None:
        """Start a command, from the present velocity.

        Raises:
            RequestRefused: The robot is busy, or the velocity exceeds its limits.
        """
        self._check_free()
        self._steering.check(self.name, command.velocity)
        self.navigator.cancel()
        self._follower.path = None
        self._steering.command = command

    def follow_path(
        self, points: Sequence[tuple[float, float]], speed: float, tick: int, goal: str | None, *, repeat: bool
    ) -> None:
        """Start to follow a path by the true pose; its first point is the present position [m].

        Raises:
            RequestRefused: The robot is busy, or the speed [m/s] exceeds its limit.
        """
        self._check_free()
        self._steering.check(self.name, Velocity(speed, 0.0))
        self.navigator.cancel()
        self._follower.start(points, speed, tick, goal, repeat=repeat)

    def detach_goals(self, goals: Container[str]) -> None:
        """See `Robot.detach_goals`."""
        path = self._follower.path
        if path is not None and path.goal in goals:
            self._follower.path = replace(path, goal=NO_CLIENT)
        goal = self.navigator.goal
        if goal is not None and goal.id in goals:
            self.navigator.goal = replace(goal, id=NO_CLIENT)
        command = self._steering.command
        if command is not None and command.goal is not None and command.goal in goals:
            self._steering.command = replace(command, goal=NO_CLIENT)

    def cancel(self, goal: str) -> Iterator[GoalResult]:
        """Cancel a goal by id; yields its result."""
        if goal in self.goals:
            yield from self.stop()

    def stop(self) -> Iterator[GoalResult]:
        """Drop the goal and stop the wheels; yields the result of the goal, if any."""
        goal = self.goal
        self._command(AT_REST)
        self._steering.clear()
        self._follower.path = None
        self.navigator.cancel()
        if goal is not None:
            yield GoalResult(goal, Outcome.CANCELED)

    def _command(self, velocity: Velocity) -> None:
        if velocity is not self._commanded:  # most commands are repeated
            self._commanded = velocity
            self.wheels.set_targets(motor_commands(self.declaration.drive, velocity))

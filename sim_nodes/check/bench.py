"""Fixtures of the rules: scenes, bodies, and assertions."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np

from sim_nodes.geometry import Array, Pose2
from sim_nodes.physics import (
    BodyModel,
    BodyState,
    Box,
    Cylinder,
    Engine,
    Part,
    PlacedRobot,
    Scene,
    Shape,
    Sphere,
    Wall,
)
from sim_nodes.robots.drive_declaration import DifferentialDrive
from sim_nodes.robots.kinematics import Velocity, motor_commands
from sim_nodes.robots.reading import load_robot

Make = Callable[[], Engine]

GRAVITY = 9.81  # [m/s^2]
ROBOT, OTHER = "robot", "second"
TURTLEBOT = load_robot("turtlebot4")
assert TURTLEBOT.mobile is not None
BASE = TURTLEBOT.mobile
assert isinstance(BASE.drive, DifferentialDrive)
assert BASE.lidar is not None
LIDAR = BASE.lidar
WHEEL_RADIUS = BASE.drive.wheel_radius  # [m]
EXTENT = (-10.0, -10.0, 10.0, 10.0)
ORIGIN = Pose2(0.0, 0.0, 0.0)
EDGE = 0.2  # [m] edge of the shapes below

CUBE = Box((EDGE, EDGE, EDGE))
SHAPES: dict[str, Shape] = {"box": CUBE, "cylinder": Cylinder(EDGE / 2, EDGE), "sphere": Sphere(EDGE / 2)}


def scene(*robots: Pose2, walls: Iterable[Wall] = ()) -> Scene:
    """Return a scene with up to two robots."""
    placed = (PlacedRobot(name, TURTLEBOT, pose) for name, pose in zip((ROBOT, OTHER), robots, strict=False))
    return Scene(tuple(walls), tuple(placed), EXTENT)


def built(make: Make, *robots: Pose2, walls: Iterable[Wall] = ()) -> Engine:
    """Return a new engine with a scene."""
    engine = make()
    engine.build(scene(*robots, walls=walls))
    return engine


def body(*shapes: Shape, static: bool = False, friction: float = 1.0) -> BodyModel:
    """Return a model of 2 kg with its parts around its origin."""
    return BodyModel(tuple(Part(shape) for shape in shapes), mass=2.0, friction=friction, static=static)


def at(x: float, y: float, z: float) -> BodyState:
    """Return the state at rest at a position [m]."""
    return BodyState((x, y, z))


def run(engine: Engine, seconds: float) -> None:
    """Simulate for a duration [s]."""
    steps(engine, round(seconds * engine.steps_per_second))


def steps(engine: Engine, count: int) -> None:
    """Make steps, regardless of contacts."""
    while count > 0:
        count -= engine.step(count)


def drive(engine: Engine, linear: float, angular: float, robot: str = ROBOT, seconds: float = 0.0) -> None:
    """Command a forward velocity [m/s] and a left turn rate [rad/s], and simulate for a duration [s]."""
    engine.command_wheels(robot, *motor_commands(BASE.drive, Velocity(linear, angular)))
    run(engine, seconds)


def expect(holds: bool, otherwise: str) -> None:
    """Raise an AssertionError with a message unless a condition holds."""
    if not holds:
        raise AssertionError(otherwise)


def expect_near(what: str, found: float | Iterable[float], wanted: float | Iterable[float], by: float) -> None:
    """Expect numbers within a tolerance."""
    found, wanted = _array(found), _array(wanted)
    off = float(np.max(np.abs(found - wanted), initial=0.0))
    if not off <= by:
        raise AssertionError(
            f"{what} is {_text(found)} instead of {_text(wanted)}: off by {off:.3g}, not {by:.3g}"
        )


def expect_state(what: str, found: BodyState, wanted: BodyState, by: float) -> None:
    """Expect a state within a tolerance; a quaternion and its negative are equal."""
    expect_near(f"the position of {what}", found.position, wanted.position, by)
    alike = math.copysign(1.0, float(np.dot(found.orientation, wanted.orientation)))
    turned = tuple(alike * value for value in found.orientation)
    expect_near(f"the orientation (w, x, y, z) of {what}", turned, wanted.orientation, by)
    expect_near(f"the linear velocity of {what}", found.linear, wanted.linear, by)
    expect_near(f"the angular velocity of {what}", found.angular, wanted.angular, by)


def expect_same(what: str, first: Sequence[object], second: Sequence[object]) -> None:
    """Expect equal observations."""
    for index, (wanted, found) in enumerate(zip(first, second, strict=True)):
        expect(wanted == found, f"{what} differs in observation {index}: {found!r} instead of {wanted!r}")


def _array(values: float | Iterable[float]) -> Array:
    return np.atleast_1d(np.asarray(values if isinstance(values, float | int) else list(values), dtype=np.float64))


def _text(values: Array) -> str:
    numbers = [f"{value:.6g}" for value in values]
    return numbers[0] if len(numbers) == 1 else f"({', '.join(numbers)})"

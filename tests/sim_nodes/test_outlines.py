"""Clearances of robots that are not round."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from sim_nodes.check.drives import robot_with
from sim_nodes.clearance import Search
from sim_nodes.geometry import Pose2, quaternion
from sim_nodes.physics import BodyModel, BodyState, Box, Capsule, Cylinder, Hull, Part, PlacedRobot, Shape, Sphere
from sim_nodes.polygons import Shadow, distance_from_polygon, distance_to_shadow, placed_corners
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.footprint import Footprint
from sim_nodes.robots.kinematics import Velocity
from sim_nodes.simulation import Simulation
from sim_nodes.worlds.loader import parse_world
from tests.sim_nodes.engines import MUJOCO_FIRST, make_engine

LONG = Footprint(((0.4, 0.2), (-0.4, 0.2), (-0.4, -0.2), (0.4, -0.2)))
WIDE = Footprint(((0.4, 0.32), (-0.4, 0.32), (-0.4, -0.32), (0.4, -0.32)))  # of the robot
DOOR = """name: door
extent: [-3, -3, 3, 3]
walls:
  - {name: left, points: [[0, 0.45], [0, 2.9]]}
  - {name: right, points: [[0, -2.9], [0, -0.45]]}
robots: [{name: mine, robot: turtlebot4, pose: {x: -1.0}}]
"""
THICKNESS = 0.1  # [m] of walls
GAP = 0.45 - THICKNESS / 2 - 0.32  # [m]
LYING = quaternion(0.0, math.pi / 2, 0.0)
TETRAHEDRON = Hull(np.array([(-0.1, 0.0, 0.0), (0.1, 0.3, 0.0), (0.1, -0.3, 0.0), (0.0, 0.0, 0.3)]).tobytes())


def long_robot() -> RobotDeclaration:
    declared = robot_with(DriveKind.SKID_STEER)
    assert declared.mobile is not None
    mobile = declared.mobile.model_copy(update={"footprint": WIDE, "radius": WIDE.radius, "clearance": 0.55})
    return declared.model_copy(update={"mobile": mobile})


def in_door(engine: str = "mujoco", *others: PlacedRobot) -> Simulation:
    world = parse_world(DOOR, "door.yaml")
    first = replace(world.robots[0], declaration=long_robot())
    return Simulation(make_engine(engine), replace(world, robots=(first, *others)), 0)


def to_shape(shape: Shape, state: BodyState) -> float:
    return distance_from_polygon(LONG.points, BodyModel((Part(shape),)), state)


@pytest.mark.parametrize(
    ("shape", "state", "expected"),
    [
        (Box((0.4, 0.2, 0.3)), BodyState((1.0, 0.0, 0.2)), 0.4),
        (Box((0.2, 0.2, 0.3)), BodyState((1.0, 0.0, 0.2), quaternion(0.0, 0.0, math.pi / 4)), 0.6 - 0.02**0.5),
        (Box((2.0, 0.1, 0.3)), BodyState((0.0, 0.0, 0.2)), 0.0),  # no corner of one is in the other
        (Sphere(0.1), BodyState((0.7, 0.6, 0.2)), 0.4),
        (Cylinder(0.1, 1.0), BodyState((0.0, -0.5, 0.5)), 0.2),
        (Cylinder(0.1, 1.0), BodyState((1.4, 0.0, 0.1), LYING), 0.5),
        (Capsule(0.1, 1.0), BodyState((1.4, 0.0, 0.1), LYING), 0.4),
        (Capsule(0.1, 1.0), BodyState((0.0, 0.0, 0.6)), 0.0),
        (TETRAHEDRON, BodyState((1.0, 0.0, 0.0)), 0.5),
    ],
)
def test_the_distance_to_a_body_is_that_of_their_outlines(shape: Shape, state: BodyState, expected: float) -> None:
    assert to_shape(shape, state) == pytest.approx(expected, abs=1e-9)


def test_the_distance_is_that_of_the_nearest_points() -> None:
    draw = np.random.default_rng(3)
    shares = np.linspace(0.0, 1.0, 60)[:, None, None]
    for _ in range(40):
        first = placed_corners(
            LONG, Pose2(draw.uniform(-1.0, 1.0), draw.uniform(-1.0, 1.0), draw.uniform(-3.0, 3.0))
        )
        second = placed_corners(LONG, Pose2(2.5, 0.0, draw.uniform(-3.0, 3.0)))
        outlines = [
            (each + shares * (np.roll(each, -1, axis=0) - each)).reshape(-1, 2) for each in (first, second)
        ]
        apart = np.hypot(*(outlines[0][:, None] - outlines[1]).reshape(-1, 2).T).min()
        found = distance_to_shadow(first, Shadow(second))
        assert found <= apart + 1e-12 and found == pytest.approx(apart, abs=0.02)
        assert distance_to_shadow(second, Shadow(first)) == pytest.approx(found, abs=1e-12)


@pytest.mark.parametrize("engine", MUJOCO_FIRST)
def test_a_robot_with_a_footprint_keeps_its_distance_in_a_narrow_door(engine: str) -> None:
    simulation = in_door(engine)
    simulation.drive("mine", "drive", Velocity(0.4, 0.0), 5.0)
    simulation.run(5.0)
    assert simulation.frames.true_pose("mine").x > 0.5
    measured = simulation.measurements().robots["mine"]
    # The circle around it, of 0.51 m, would overlap both walls.
    assert measured.closest_approach == pytest.approx(GAP, abs=0.01)
    assert measured.closest_entity in ("left", "right") and measured.contacts == 0


def test_turns_in_place_bring_corners_nearer() -> None:
    simulation = in_door()
    robot = simulation.engine.body_state("mine")
    simulation.move("mine", replace(robot, position=(-0.65, 1.0, robot.position[2])))
    simulation.start_run()
    simulation.drive("mine", "turn", Velocity(0.0, 0.5), 3.0)
    simulation.run(3.0)
    measured = simulation.measurements().robots["mine"]
    assert measured.path_length < 0.1
    assert measured.closest_approach == pytest.approx(0.65 - THICKNESS / 2 - WIDE.radius, abs=0.03)


def test_round_robots_and_those_with_a_footprint_have_one_distance() -> None:
    placed = parse_world(DOOR, "door.yaml").robots[0]
    simulation = in_door("mujoco", replace(placed, name="round", pose=Pose2(-1.0, 0.9, 0.0)))
    clearances, places = simulation.run_data.clearances, simulation.frames
    expected = pytest.approx(0.9 - 0.32 - 0.164, abs=1e-3)
    assert clearances.between("mine", places.true_pose("mine"), "round").distance == expected
    assert clearances.between("round", places.true_pose("round"), "mine").distance == expected
    (nearest,) = clearances.nearest([Search("mine", places.true_pose("mine"))])
    assert nearest.entity == "round" and nearest.distance == expected

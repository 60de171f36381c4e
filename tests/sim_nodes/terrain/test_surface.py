"""Terrain in the navigation of robots: maps with obstacles, and scans without the ground."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from sim_nodes.check.bench import BASE
from sim_nodes.navigation.maps import NavigationMap, build_map
from sim_nodes.terrain.surface import Surface
from sim_nodes.worlds.loader import parse_world
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.engines import MUJOCO_FIRST, PYBULLET_IN_MORE, make_engine

HEAD = """
name: w
extent: [-5, -3, 5, 3]
walls:
  - points: [[-4.5, -2.5], [4.5, -2.5], [4.5, 2.5], [-4.5, 2.5], [-4.5, -2.5]]
terrain:
"""
ROBOTS = "robots: [{name: turtlebot4, robot: turtlebot4, pose: {x: X}}]\n"
HILL = """
  - {ramp: {size: [2.0, 1.6], angle: 0.08}, center: [-1.5, 0.0]}
  - {platform: {size: [1.0, 1.6], height: 0.16034}}
  - {ramp: {size: [2.0, 1.6], angle: 0.08}, center: [1.5, 0.0], yaw: 3.141592653589793}
"""


def passable(terrain: str, **limits: float) -> NavigationMap:
    world = parse_world(f"{HEAD}{terrain}", "w")
    declaration = BASE.model_copy(update={"navigation": BASE.navigation.model_copy(update=limits)})
    return Surface(world.ground, build_map(world.extent, world.walls)).passable(declaration)


def room(known: NavigationMap, x: float, y: float) -> float:
    """Return the distance of a point to the nearest obstacle [m]."""
    return float(known.distance[known.grid.cell(x, y)])


def test_gentle_ramps_are_free_between_their_sides() -> None:
    known = passable(HILL)
    assert room(known, -2.2, 0.0) > 0.6
    assert room(known, 0.0, 0.0) == pytest.approx(0.8, abs=0.06), "the sides of the platform"
    assert room(known, 0.0, 0.8) < 0.06
    assert room(known, -2.5, 0.8) > 0.1, "the ramp begins at the floor"


def test_steep_ramps_and_high_steps_are_obstacles() -> None:
    steep = "  - {ramp: {size: [2.0, 1.0], angle: 0.15}}\n"
    assert room(passable(steep), 0.0, 0.0) < 0.06
    assert room(passable(steep, max_slope=0.2), -0.8, 0.0) > 0.3
    curb = "  - {platform: {size: [2.0, 2.0], height: 0.03}}\n"
    assert room(passable(curb), -1.0, 0.0) < 0.06
    assert room(passable(curb), 0.0, 0.0) == pytest.approx(1.0, abs=0.06), "it is level"
    assert room(passable(curb, max_step=0.04), -1.0, 0.0) > 1.0
    assert room(passable("  - {platform: {size: [2, 2], height: 0.01}}\n"), -1.0, 0.0) > 1.0, (
        "a third of the wheel"
    )


def goal(world: str, engine: str) -> tuple[Client, list[tuple[float, float, float]]]:
    """Drive to a goal behind the middle of the world; return the positions of the robot."""
    client = Client(world, engine=engine)
    client.localise(pose(-3.2, 0.0))
    client.navigate(pose(3.0, 0.0))
    simulation, positions = client.simulator.simulation, []
    while simulation.robot(ROBOT).goals:
        simulation.run(simulation.time + 0.5)
        positions.append(simulation.engine.body_state(ROBOT).position)
        assert simulation.time < 60.0
    assert client.truth.distance(3.0, 0.0) < 0.1
    assert client.estimate.distance(client.truth.x, client.truth.y) < 0.1
    assert simulation.robot(ROBOT).mobile.recoveries == 0
    return client, positions


@pytest.mark.parametrize("engine", PYBULLET_IN_MORE)
def test_a_navigating_robot_crosses_a_ramp(engine: str, tmp_path: Path) -> None:
    make_engine(engine)
    path = tmp_path / "w.yaml"
    path.write_text(HEAD + HILL + ROBOTS.replace("X", "-3.2"))
    _, positions = goal(str(path), engine)
    assert max(z for _, _, z in positions) == pytest.approx(0.16, abs=0.01)
    assert max(abs(y) for _, y, _ in positions) < 0.2, "the straight way"


@pytest.mark.parametrize("engine", MUJOCO_FIRST)
def test_a_navigating_robot_goes_around_a_steep_ramp(engine: str, tmp_path: Path) -> None:
    make_engine(engine)
    path = tmp_path / "w.yaml"
    path.write_text(HEAD + HILL.replace("0.08", "0.2").replace("0.16034", "0.4054") + ROBOTS.replace("X", "-3.2"))
    _, positions = goal(str(path), engine)
    assert max(z for _, _, z in positions) < 0.01
    assert max(abs(y) for _, y, _ in positions) > 0.9


@pytest.mark.parametrize("engine", PYBULLET_IN_MORE)
def test_scans_of_a_navigating_robot_are_without_ground(engine: str, tmp_path: Path) -> None:
    make_engine(engine)
    path = tmp_path / "w.yaml"
    path.write_text(HEAD + HILL + ROBOTS.replace("X", "2.2"))  # on the ramp that leads down
    simulation = Client(str(path), engine=engine).simulator.simulation
    base = simulation.robot(ROBOT).mobile
    base.set_initial_pose(simulation.frames.true_pose(ROBOT), 0)
    simulation.run(0.3)
    arrived = base.sensors["lidar"].arrived
    assert arrived is not None and base._scan is not None
    raw, kept = arrived.data.ranges, base._scan.ranges
    removed = np.isfinite(raw) & ~np.isfinite(kept)
    assert 10 < removed.sum() < 150, "the floor ahead"
    ahead = removed & (np.abs(arrived.data.angles % (2 * np.pi)) < 0.3)
    assert ahead.any()
    assert np.array_equal(raw[~removed], kept[~removed])
    assert np.isfinite(kept).sum() > 50, "walls"

"""Walls, doors, lifts, maps and shortest paths of worlds with terrain."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from sim_nodes.__main__ import ENGINES
from sim_nodes.buildings.parts import Door, Lift
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.path_efficiency import shortest_length
from sim_nodes.worlds.loader import World, parse_world
from tests.sim_nodes.client import ROBOT, Client

HEAD = "name: w\nextent: [-5, -5, 5, 5]\nwall_height: 0.5\n"
RAMP = "terrain:\n  - {ramp: {size: [2, 2], heights: [0.0, 0.2]}, center: [1, 0]}\n"
PLATFORM = "terrain:\n  - {platform: {size: [2, 2], height: 0.3}, center: [1, 0]}\n"
ROBOTS = "robots:\n  - {name: turtlebot4, robot: turtlebot4, pose: {x: -2}}\n"


def world(*parts: str) -> World:
    return parse_world(HEAD + "".join(parts), "w.yaml")


def test_walls_begin_at_the_lowest_ground_and_rise_above_the_highest() -> None:
    box = "walls:\n  - {center: [1.5, 0], size: [0.9, 0.1]}\n"
    [wall] = world(box, RAMP).walls
    assert (wall.z, wall.z + wall.height) == pytest.approx((0.105, 0.5 + 0.195), abs=1e-9)
    [across] = world("walls:\n  - {points: [[-1, 0], [3, 0]]}\n", RAMP).walls
    assert (across.z, across.height) == pytest.approx((0.0, 0.7), abs=0.005)
    [flat] = world(box).walls
    assert (flat.z, flat.height) == (0.0, 0.5)


@pytest.mark.parametrize("engine", ENGINES)
def test_lidars_see_walls_on_platforms(engine: str, tmp_path: Path) -> None:
    path = tmp_path / "w.yaml"
    robots = ROBOTS.replace("x: -2", "x: 0.5")
    path.write_text(f"{HEAD}walls:\n  - {{points: [[1.5, -0.5], [1.5, 0.5]], height: 0.3}}\n{PLATFORM}{robots}")
    simulation = Client(str(path), engine=engine).simulator.simulation
    around = np.array([[1.0, 0.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, -1.0, 0.0]])
    assert simulation.engine.cast_rays(ROBOT, "rplidar_link", around, 8.0).min() < 2.0
    assert simulation.engine.overlaps(ROBOT) == ()


def test_doors_and_lifts_stand_on_the_ground_under_them() -> None:
    parts = "doors:\n  - {name: d, pose: {x: 1}}\n  - {name: e, pose: {x: 1}, z: 0.1}\n"
    lift = "lifts:\n  - {name: l, pose: {x: 1}, floors: [0.0, 1.0]}\n"
    door, low, hoist = world(parts, lift, PLATFORM).building
    assert isinstance(door, Door) and isinstance(low, Door) and isinstance(hoist, Lift)
    assert [each.leaves[0].height for each in (door, low)] == pytest.approx([0.31, 0.11])
    assert hoist.floors == pytest.approx((0.299, 1.3))


def test_maps_and_shortest_paths_have_terrain_that_no_robot_passes(tmp_path: Path) -> None:
    path = tmp_path / "w.yaml"
    path.write_text(HEAD + PLATFORM + ROBOTS)
    client = Client(str(path))
    simulation = client.simulator.simulation
    found = client.ask(wire.GET_MAP, wire.Empty())
    cells = np.frombuffer(found.cells, np.uint8)
    assert (cells > 0).any()
    assert not (simulation.known.distance == 0.0).any()
    assert _detour(simulation.shown_map) > _detour(simulation.known) + 0.3


def _detour(known: NavigationMap) -> float:
    return shortest_length(known, 0.2, Pose2(-2.0, 0.0, 0.0), Pose2(3.0, 0.0, 0.0))


def test_props_on_a_platform_are_in_maps() -> None:
    prop = "props:\n  - {name: p, box: [0.4, 0.4, 0.4], pose: {x: 1}}\n"
    high = PLATFORM.replace("0.3", "0.8")
    assert len(world(prop, high).outlines) == len(world(prop).outlines) == 1

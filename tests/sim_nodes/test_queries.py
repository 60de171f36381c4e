"""Queries of a node: entities, poses, worlds, frames and maps."""

from __future__ import annotations

import math
from typing import Any

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Bounds, Category, EntityFilter, Position3D, SimulationState
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.worlds.loader import available_worlds
from tests.sim_nodes.client import BOX, ROBOT, TRUTH, Client, pose

STATIC = BOX.replace('<link name="link">', '<static>true</static><link name="link">')


@pytest.fixture
def full(maze: Client) -> Client:
    maze.spawn("box", pose(2.0, -2.0, z=0.1))
    maze.spawn("rock", pose(-3.0, 3.0, z=0.1), STATIC)
    return maze


def found(client: Client, **of: object) -> tuple[str, ...]:
    return client.ask(wire.GET_ENTITIES_STATES, EntityFilter.model_validate(of)).names


def test_entities_are_found_by_name_category_and_place(full: Client) -> None:
    assert found(full) == ("box", "rock", ROBOT, "walls")
    assert found(full, filter="[br]o.*") == ("box", "rock")
    assert found(full, categories=(Category.ROBOT, Category.DYNAMIC_OBJECT)) == ("box", ROBOT)
    east = Bounds(lower=Position3D(x=1.0, y=-5.0, z=-1.0), upper=Position3D(x=5.0, y=5.0, z=1.0))
    assert found(full, bounds=east) == ("box",)
    assert found(full, bounds=east, categories=(Category.ROBOT,)) == ()
    states = full.ask(wire.GET_ENTITIES_STATES, EntityFilter(filter="box")).states
    assert [state.pose.position.x for state in states] == [2.0]


def test_invalid_filters_are_refused(full: Client) -> None:
    with pytest.raises(RequestRefused, match=r"unknown category 3; categories: 0 \(object\), 1 \(robot\)"):
        found(full, categories=(3,))
    with pytest.raises(RequestRefused, match="finite number"):
        found(full, bounds=Bounds(lower=Position3D(x=math.nan), upper=Position3D()))
    with pytest.raises(RequestRefused, match="invalid regular expression"):
        found(full, filter="(")


def test_entities_have_descriptions_and_categories(full: Client) -> None:
    info = {name: full.ask(wire.GET_ENTITY_INFO, wire.EntityName(name=name)) for name in found(full)}
    assert {name: each.category for name, each in info.items()} == {
        "box": Category.DYNAMIC_OBJECT,
        "rock": Category.STATIC_OBJECT,
        ROBOT: Category.ROBOT,
        "walls": Category.STATIC_OBJECT,
    }
    assert info["box"].description == "spawned at 0.000 s"
    with pytest.raises(RequestRefused, match="unknown entity 'moon'"):
        full.ask(wire.GET_ENTITY_INFO, wire.EntityName(name="moon"))


def bounds(client: Client, name: str) -> list[list[float]]:
    found = client.ask(wire.GET_ENTITY_BOUNDS, wire.EntityName(name=name)).bounds
    assert found is not None
    return [[round(getattr(corner, axis), 3) for axis in "xyz"] for corner in (found.lower, found.upper)]


def test_bounds_of_entities_are_returned(full: Client) -> None:
    assert bounds(full, "box") == [[-0.15, -0.15, 0.0], [0.15, 0.15, 0.3]]
    (left, right, low), (ahead, leftmost, high) = bounds(full, ROBOT)
    assert (left, right, ahead, leftmost) == (-0.164, -0.164, 0.164, 0.164)
    assert low == pytest.approx(0.0, abs=5e-3)
    assert 0.15 < high < 0.4
    lower, upper = bounds(full, "walls")
    assert lower[2] == 0.0
    assert [upper[0] - lower[0], upper[1] - lower[1]] == pytest.approx([10.6, 10.6])


def test_requests_without_a_world_are_refused(full: Client) -> None:
    full.ask(wire.UNLOAD_WORLD, wire.Empty())
    state = full.ask(wire.GET_SIMULATION_STATE, wire.Empty())
    assert (state.state, state.time) == (SimulationState.NO_WORLD, 0.0)
    features = full.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())
    assert (features.world, features.robots) == ("", ())
    requests: tuple[tuple[wire.Verb[Any, Any], wire.Message], ...] = (
        (wire.ADVANCE, wire.Advance(until=1.0)),
        (wire.GET_ENTITIES, wire.EntityFilter()),
        (wire.UNLOAD_WORLD, wire.Empty()),
        (wire.SET_SIMULATION_STATE, wire.SetSimulationState(state=SimulationState.PLAYING)),
    )
    for verb, request in requests:
        with pytest.raises(RequestRefused, match="no world is loaded") as refused:
            full.ask(verb, request)
        assert refused.value.code == wire.WorldResult.NO_WORLD_LOADED
    assert full.ask(wire.LOAD_WORLD, wire.LoadWorld(world="", seed=0)).world == "maze"
    assert found(full) == (ROBOT, "walls")


def test_world_and_state_are_returned(full: Client) -> None:
    world = full.ask(wire.GET_CURRENT_WORLD, wire.Empty())
    assert (world.name, world.source) == ("maze", "maze")
    assert full.ask(wire.GET_AVAILABLE_WORLDS, wire.GetAvailableWorlds()).names == available_worlds()
    full.advance(0.2)
    state = full.ask(wire.GET_SIMULATION_STATE, wire.Empty())
    assert (state.state, state.time) == (SimulationState.PAUSED, 0.2)


def test_transforms_include_all_frames_and_true_poses(full: Client) -> None:
    def transforms() -> dict[str, wire.Pose3D | None]:
        return {each.frame: each.pose for each in full.ask(wire.GET_TRANSFORMS, wire.Empty()).transforms}

    before = transforms()
    assert before["base_link"] is None
    truth = before[TRUTH]
    assert truth is not None and truth.position.x == pytest.approx(0.0, abs=1e-6)
    full.localise(pose(0.1, 0.0))
    believed = transforms()["base_link"]
    assert believed is not None and believed.position.x == pytest.approx(0.1)


def test_descriptions_of_robots_are_returned(maze: Client) -> None:
    described = maze.ask(wire.GET_ROBOT_DESCRIPTION, wire.RobotName(robot=ROBOT))
    assert described.lidar is not None
    assert (described.base_link, described.lidar.link, described.arm) == ("base_link", "rplidar_link", None)
    assert set(described.sensors) == {"lidar", "odometry", "imu", "bumper"}
    assert described.urdf.count("<joint") == 4
    cell = Client("arm_cell").ask(wire.GET_ROBOT_DESCRIPTION, wire.RobotName(robot="ur10e"))
    assert cell.arm is not None
    assert (len(cell.arm.joints), cell.max_speed, cell.lidar) == (6, 0.0, None)


def test_the_map_contains_static_obstacles(maze: Client) -> None:
    grid = maze.ask(wire.GET_MAP, wire.Empty())
    assert len(grid.cells) == grid.columns * grid.rows

    def occupied(x: float, y: float) -> int:
        column, row = int((x - grid.x) / grid.resolution), int((y - grid.y) / grid.resolution)
        return grid.cells[row * grid.columns + column]

    assert occupied(0.0, 0.0) == 0
    for wall in maze.simulator.simulation.world.walls:
        assert occupied(wall.x, wall.y) == 100

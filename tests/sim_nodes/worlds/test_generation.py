"""Generated worlds: the same for a seed, passable, and refused when no world is."""

from __future__ import annotations

import re

import numpy as np
import pytest
from scipy.ndimage import label

from seoro.bridges import wire
from sim_nodes.geometry import Pose2
from sim_nodes.navigation.maps import build_map
from sim_nodes.simulator import Simulator
from sim_nodes.worlds.generation.obstacles import automaton
from sim_nodes.worlds.loader import World, WorldError, load_world, parse_world
from tests.sim_nodes.client import Client
from tests.sim_nodes.engines import make_engine

WORLDS = {"office": 0.35, "obstacle_field": 0.25, "labyrinth": 0.4}  # with the clearance in their files


def world_of(generate: str, more: str = "", seed: int = 0) -> World:
    return parse_world(f"name: w\ngenerate: {{{generate}}}\n{more}", "w.yaml", seed=seed)


def poses(world: World) -> dict[str, Pose2]:
    return {pose.name: pose.place.planar for pose in world.poses}


@pytest.mark.parametrize("name", WORLDS)
def test_a_world_is_the_same_for_a_seed_and_another_one_for_another(name: str) -> None:
    assert load_world(name, 3) == load_world(name, 3) == load_world(f"{name}?generate.seed=3", 8)
    assert load_world(name, 4).walls != load_world(name, 3).walls


@pytest.mark.parametrize(("name", "clearance"), WORLDS.items())
@pytest.mark.parametrize("seed", range(8))
def test_a_robot_can_move_between_all_named_poses(name: str, clearance: float, seed: int) -> None:
    world = load_world(name, seed)
    solids = [prop for prop in world.props if not prop.model.static]
    assert len(solids) == (4 if name == "office" else 0)
    known = build_map(world.extent, world.walls, world.outlines)
    areas, _ = label(known.distance >= clearance, structure=np.ones((3, 3)))
    found = {int(areas[known.grid.cell(pose.x, pose.y)]) for pose in poses(world).values()}
    assert len(found) == 1
    assert 0 not in found
    start = poses(world)["start"]
    assert world.robots[0].pose.distance(start.x, start.y) == 0.0


def test_rooms_have_doors_of_the_width_in_the_file() -> None:
    world = world_of("rooms: {count: 8, size: [14, 9], corridor: 1.5, door: 1.1, loops: 1}")
    known = build_map(world.extent, world.walls)
    doors = [pose for name, pose in poses(world).items() if name.startswith("door_")]
    assert len([name for name in poses(world) if name.startswith("room_")]) == 8
    assert len(doors) >= 8
    for door in doors:
        through = [door.compose(Pose2(x, 0.0, 0.0)) for x in (-0.5, 0.0, 0.5)]
        free = [float(known.distance[known.grid.cell(each.x, each.y)]) for each in through]
        assert free[1] == pytest.approx(0.55, abs=0.04)
        assert min(free) > 0.3


def test_without_loops_rooms_are_a_tree() -> None:
    world = world_of("rooms: {count: 7, loops: 0}")
    assert len([name for name in poses(world) if name.startswith("door_")]) == 6


def test_a_maze_without_loops_has_one_way() -> None:
    world = world_of("maze: {columns: 5, rows: 4, cell: 1.5}")
    known = build_map(world.extent, world.walls)
    _, parts = label(known.distance < 0.3, structure=np.ones((3, 3)))
    assert parts == 1, "all walls hang together, so that the way is the only one"


def test_the_automaton_fills_cells_among_filled_ones_and_frees_lonely_ones() -> None:
    ring = np.array([[1, 1, 1, 0, 0], [1, 0, 1, 0, 0], [1, 1, 1, 0, 1]], dtype=bool)
    after = automaton(ring, 1, 1)
    assert after[1, 1]
    assert not after[2, 4]
    assert after[:, :3].all()


def test_walls_of_the_file_count_as_obstacles() -> None:
    wall = "walls: [{points: [[0, -5], [0, 5]]}]\n"
    with pytest.raises(WorldError, match=r"w.yaml:2: generate: no valid world in 50 draws .*: no way"):
        world_of("obstacles: {fill: 0}", wall)


@pytest.mark.parametrize(
    ("generate", "words"),
    [
        ("seed: 1", "generate: .*expected one of rooms, maze, obstacles, found none"),
        ("maze: {}, rooms: {}", "found rooms and maze"),
        ("maze: {cell: 0.6}", "no way with 0.3 m of clearance from start"),
        ("rooms: {count: 40, size: [4, 4]}", r"rooms fit into `size`; expected 40 \(`count`\)"),
        ("rooms: {size: [8, 4], corridor: 3}", "expected 2 m"),
        ("obstacles: {size: [50, 50], cell: 0.1}", "found 250000 cells in the field; expected at most 10000"),
        ("maze: {}, clutter: {fixed: 40, smallest: 2, largest: 2}", "no free floor is left for `clutter`"),
        ("maze: {}, clutter: {smallest: 0.6}", "expected `smallest` of `clutter` up to `largest`"),
    ],
)
def test_impossible_parameters_are_refused(generate: str, words: str) -> None:
    with pytest.raises(WorldError, match=words):
        world_of(generate)


def test_generated_things_have_names_of_their_own() -> None:
    more = "props: [{name: clutter_1, cube: 0.2}]\n"
    with pytest.raises(WorldError, match=r"w.yaml:3: props.0.name: 'clutter_1' is in use"):
        world_of("maze: {}, clutter: {fixed: 1, largest: 0.2}", more)
    with pytest.raises(WorldError, match=r"poses.0.name: 'start' is in use by a generated pose"):
        world_of("maze: {}", "poses: [{name: start, pose: {}}]\n")
    with pytest.raises(WorldError, match="beside `generate`"):
        world_of("maze: {}", "extent: [-1, -1, 1, 1]\n")


def test_a_pose_of_a_robot_may_be_relative_to_a_named_one() -> None:
    robots = "robots: [{name: a, robot: turtlebot4, pose: {at: POSE, x: 0.2}}]\n"
    world = world_of("maze: {}", robots.replace("POSE", "goal"))
    assert world.robots[0].pose == poses(world)["goal"].compose(Pose2(0.2, 0.0, 0.0))
    known = re.escape("unknown pose 'exit' (poses: start, goal)")
    with pytest.raises(WorldError, match=rf"w.yaml:3: robots.0.pose.at: {known}"):
        world_of("maze: {}", robots.replace("POSE", "exit"))


def test_a_node_generates_by_the_seed_of_the_run(empty: Client) -> None:

    def walls(seed: int) -> bytes:
        empty.ask(wire.LOAD_WORLD, wire.LoadWorld(world="office", seed=seed))
        return empty.ask(wire.GET_MAP, wire.Empty()).cells

    assert walls(1) == walls(1) != walls(2)


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_nothing_overlaps_in_an_office(engine: str) -> None:

    simulator = Simulator(make_engine(engine), "office", 5)
    assert simulator.simulation.engine.overlaps("turtlebot4") == ()

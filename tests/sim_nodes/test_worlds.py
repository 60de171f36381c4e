from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import label

from sim_nodes.navigation.maps import build_map
from sim_nodes.physics import Wall
from sim_nodes.worlds.loader import WorldError, available_worlds, load_world, parse_world
from tests.sim_nodes.plans import plan_to

START, VIA, BOX, GOAL = (0.0, 0.0), (1.5, -1.5), (2.0, -2.0), (3.0, -3.0)


def test_bundled_worlds_are_listed_and_load() -> None:
    assert available_worlds() == (
        "arm_cell",
        "corridor",
        "empty",
        "hall",
        "labyrinth",
        "maze",
        "obstacle_field",
        "office",
        "rooms",
    )
    for name in available_worlds():
        world = load_world(name)
        assert world.name == name
        assert world.robots[0].name == ("ur10e" if name == "arm_cell" else "turtlebot4")


def test_the_path_through_the_maze_crosses_the_position_of_the_box() -> None:
    world = load_world("maze")
    known = build_map(world.extent, world.walls)
    path = plan_to(known, START, GOAL)
    assert path is not None
    near = {point: float(np.hypot(*(path.points - np.array(point)).T).min()) for point in (VIA, BOX)}
    assert near[VIA] < 0.36, "nothing would be spawned in the example"
    assert near[BOX] < 0.3, "the box would not be in the way"
    assert known.distance[known.grid.cells(*path.points.T)].min() >= 0.28


def test_a_gap_of_0_8_m_is_beside_the_box() -> None:
    world = load_world("maze")
    known = build_map(world.extent, (*world.walls, Wall("box", *BOX, 0.0, 0.3, 0.3, 0.3)))
    assert plan_to(known, START, GOAL, clearance=0.4) is not None


def test_the_whole_maze_is_reachable() -> None:
    world = load_world("maze")
    known = build_map(world.extent, world.walls)
    inside = known.distance >= 0.35
    _, count = label(inside, structure=np.ones((3, 3)))
    assert count == 1, "some corridor of the maze is closed"


def test_distances_of_the_map_are_exact() -> None:
    known = build_map((-2.0, -2.0, 2.0, 2.0), (Wall("w", 0.0, 0.0, math.pi / 4, 2.0, 0.2, 0.5),))
    x, y = 1.025, -1.025  # the centre of a cell, straight across the wall
    assert known.distance[known.grid.cell(x, y)] == pytest.approx(math.hypot(x, y) - 0.1)
    assert known.distance[known.grid.cell(0.0, 0.0)] == 0.0


def world_text(walls: str = "", robots: str = "") -> str:
    return f"name: w\nextent: [-2, -2, 2, 2]\nwalls: [{walls}]\nrobots: [{robots}]\n"


def test_walls_are_boxes_or_lines() -> None:
    world = parse_world(
        world_text("{name: a, center: [1, 0], size: [0.5, 0.2], yaw: 0.3}, {points: [[0, 0], [1, 0], [1, 1]]}"),
        "w",
    )
    assert [wall.name for wall in world.walls] == ["a", "walls", "walls"]
    assert world.walls[1] == Wall("walls", 0.5, 0.0, 0.0, 1.1, 0.1, 0.5)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("name: [", "invalid YAML"),
        ("- 1", "the file"),
        (world_text() + "colour: red\n", "colour: unknown key `colour`"),
        (world_text("{points: [[0, 0], [0, 0]]}"), "are equal"),
        (world_text("{points: [[0, 0], [1, 0]], center: [0, 0], size: [1, 1]}"), "walls.0: .*either"),
        (world_text("{center: [0, 0]}"), "expected both"),
        (world_text("{points: [[0, 0], [.nan, 0]]}"), "walls.0.points.1.0"),
        (world_text(robots="{name: r, robot: spot}"), "unknown kind of robot 'spot' \\(kinds: turtlebot4"),
        (
            world_text(robots="{name: r, robot: turtlebot4}, {name: r, robot: turtlebot4}"),
            "duplicate name of robots",
        ),
        (
            world_text("{points: [[0, 0], [1, 0]]}", "{name: walls, robot: turtlebot4}"),
            "duplicate name of a robot and a wall",
        ),
        ("name: w\nextent: [2, 2, -2, -2]\n", "extent"),
        (
            world_text(robots=", ".join(f"{{name: r{each}, robot: turtlebot4}}" for each in range(65))),
            "robots: found 65 items, expected 64 at most",
        ),
    ],
)
def test_an_invalid_world_file_is_refused_with_the_key(text: str, words: str) -> None:
    with pytest.raises(WorldError, match=words) as error:
        parse_world(text, "w.yaml", Path())
    assert str(error.value).startswith("w.yaml")


HALL = """name: hall
extent: [-3, -3, 3, 3]
walls:
  - points: [[-2, -2], [2, -2]]
robots:
  - name: turtlebot4
    robot: turtlebot4
    pose: {x: 0.0}
props:
  - {name: crate, cube: 0.3, pose: {x: 1, y: 1}}
"""


@pytest.mark.parametrize(
    ("line", "wrong", "words"),
    [
        (7, "    robot: spot", "robots.0.robot: unknown kind of robot 'spot'"),
        (7, "    robot: [turtlebot4", "invalid YAML"),
        (7, "    robot: turtlebot4\n    colour: red", "robots.0.colour: unknown key"),
        (4, "  - points: [[-2, -2], [.nan, -2]]", "walls.0.points.1.0"),
        (8, "    pose: {x: 0.0, z: 1.0}", "robots.0.pose.z: unexpected z: a turtlebot4 stands on the floor"),
        (10, "  - {name: crate, cube: 0.3, pose: {x: 1, y: 1, z: 0}}", "props.0.pose.z: 'crate' would be"),
        (10, "  - {name: crate, model: none.sdf, pose: {x: 1, y: 1}}", "props.0.model: cannot read"),
        (2, "extent: [3, 3, -3, -3]", "extent"),
        (7, "\trobot: turtlebot4", "invalid YAML"),
    ],
)
def test_an_error_in_a_world_file_is_reported_with_its_line(line: int, wrong: str, words: str) -> None:
    lines = HALL.splitlines()
    lines[line - 1] = wrong
    where = line + wrong.count("\n")
    with pytest.raises(WorldError) as error:
        parse_world("\n".join(lines), "hall.yaml", Path())
    message = str(error.value)
    assert words in message
    if words != "extent":  # errors of a whole entry, and of the whole file
        expected = (
            {where, where + 1} if words == "invalid YAML" else {where}
        )  # a bracket is missed on the next line
        assert any(message.startswith(f"hall.yaml:{number}: ") for number in expected), message


def test_unknown_worlds_are_distinguished_from_invalid_ones(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match="worlds: arm_cell, corridor, empty") as unknown:
        load_world("moon")
    assert unknown.value.missing
    with pytest.raises(WorldError, match="cannot read"):
        load_world(str(tmp_path / "none.yaml"))
    own = tmp_path / "own.yaml"
    own.write_text(world_text("{points: [[0, 0], [1, 0]]}"))
    assert load_world(str(own)).name == "w"

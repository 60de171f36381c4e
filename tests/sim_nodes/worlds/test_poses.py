"""Named poses of worlds."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import FilterMode, TagsFilter
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.worlds.loader import WorldError, parse_world
from tests.sim_nodes.client import Client

WORLD = """name: yard
extent: [-5, -5, 5, 5]
robots:
  - {name: turtlebot4, robot: turtlebot4}
poses:
"""
DOCK = (
    "  - {name: dock, pose: {x: 2.0, y: -1.0, yaw: 1.5}, description: by the door, tags: [goal, charging],\n"
    "     bounds: {lower: [-0.5, -0.4, 0.0], upper: [0.5, 0.4, 1.0]}}\n"
)
SHELF = "  - {name: shelf, pose: {x: 0.0, y: 3.0, z: 1.2}, tags: [spawn]}\n"


def client(folder: Path, poses: str = DOCK + SHELF) -> Client:
    (folder / "yard.yaml").write_text(WORLD + poses)
    return Client(str(folder / "yard.yaml"))


def names(asked: Client, *tags: str, mode: int = FilterMode.ANY) -> list[str]:
    answer = asked.ask(wire.GET_NAMED_POSES, TagsFilter(tags=tags, filter_mode=mode))
    return [pose.name for pose in answer.poses]


def test_named_poses_have_descriptions_and_tags(tmp_path: Path) -> None:
    dock, shelf = client(tmp_path).ask(wire.GET_NAMED_POSES, TagsFilter()).poses
    assert (dock.name, dock.description, dock.tags) == ("dock", "by the door", ("goal", "charging"))
    position = dock.pose.position
    assert (position.x, position.y, position.z) == (2.0, -1.0, 0.0)
    assert math.isclose(dock.pose.orientation.yaw, 1.5)
    assert shelf.pose.position.z == 1.2


def test_named_poses_are_filtered_by_tags(tmp_path: Path) -> None:
    asked = client(tmp_path)
    assert names(asked, "goal", "spawn") == ["dock", "shelf"]
    assert names(asked, "goal", "charging", mode=FilterMode.ALL) == ["dock"]
    assert names(asked, "goal", "spawn", mode=FilterMode.ALL) == []


def test_bounds_of_named_poses_are_returned(tmp_path: Path) -> None:
    asked = client(tmp_path)
    bounds = asked.ask(wire.GET_NAMED_POSE_BOUNDS, wire.PoseName(name="dock")).bounds
    assert bounds is not None
    assert (bounds.lower.x, bounds.upper.z) == (-0.5, 1.0)
    assert asked.ask(wire.GET_NAMED_POSE_BOUNDS, wire.PoseName(name="shelf")).bounds is None
    with pytest.raises(RequestRefused, match="unknown pose 'door' of the world; poses: dock, shelf") as refused:
        asked.ask(wire.GET_NAMED_POSE_BOUNDS, wire.PoseName(name="door"))
    assert refused.value.code == wire.Result.NOT_FOUND


def test_snapshots_contain_named_poses(tmp_path: Path) -> None:
    resumed = Client(client(tmp_path).ask(wire.SAVE_STATE, wire.Empty()), None)
    assert names(resumed) == ["dock", "shelf"]


@pytest.mark.parametrize(
    ("poses", "words"),
    [
        (
            "  - {name: far, pose: {x: 7.0}}\n",
            "yard.yaml:6: poses.0.pose: 'far' at (7, 0) is outside of the world",
        ),
        (SHELF + "  - {name: bare}\n", "yard.yaml:7: poses.1.pose: Field required"),
        (SHELF + SHELF, "duplicate name in `poses`"),
        ("  - {name: a b, pose: {}}\n", "yard.yaml:6: poses.0.name: String should match"),
        ("  - {name: a, pose: {}, tags: [two words]}\n", "yard.yaml:6: poses.0.tags.0: String should match"),
        (
            "  - {name: a, pose: {}, bounds: {lower: [0, 0, 0], upper: [1, 0, 1]}}\n",
            "yard.yaml:6: poses.0.bounds: Value error, expected `lower` below `upper`",
        ),
    ],
)
def test_errors_have_line_numbers(poses: str, words: str) -> None:
    with pytest.raises(WorldError) as error:
        parse_world(WORLD + poses, "yard.yaml")
    assert words in str(error.value)

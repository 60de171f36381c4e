"""Arms of users: a declaration and a URDF, named by a world file."""

from __future__ import annotations

import re
from importlib import resources
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes.client import Client
from tests.sim_nodes.manipulation.cell import down

WORLD = "name: w\nextent: [-2, -2, 2, 2]\nrobots: [{name: mine, robot: mine.yaml, pose: {z: 0.5}}]\n"
PAN = (
    "    - {name: shoulder_pan_joint, home: 0.0, max_acceleration: 5.0, "
    "stiffness: 6000.0, damping: 400.0, armature: 0.1}\n"
)


def world_with(folder: Path, old: str = "", new: str = "") -> str:
    """Write a world with a UR10e whose declaration is changed."""
    robots = resources.files("sim_nodes.robots")
    declaration = robots.joinpath("ur10e.yaml").read_text(encoding="utf-8")
    assert old in declaration
    (folder / "mine.yaml").write_text(declaration.replace(old, new, 1))
    (folder / "ur10e.urdf").write_text(robots.joinpath("ur10e.urdf").read_text(encoding="utf-8"))
    path = folder / "w.yaml"
    path.write_text(WORLD)
    return str(path)


def test_a_user_declared_arm_moves(tmp_path: Path) -> None:
    client = Client(world_with(tmp_path))
    request = wire.MoveToPose(id="move", robot="mine", pose=down(0.6, 0.2, 0.3), frame="base_link")
    client.ask(wire.MOVE_TO_POSE, request)
    assert client.run_until("move")[0].outcome is Outcome.SUCCEEDED


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        (PAN, "", "from base_link to tcp; expected"),
        ("tool_link: tcp", "tool_link: left_finger", "from base_link to left_finger; expected"),
        ("fixed: true", "fixed: false", "missing `fixed: true`"),
        ("home: 1.5708", "home: 4.0", "invalid `home` 4.000 rad of elbow_joint; expected -3.142 to 3.142 rad"),
        ("elbow_joint", "knee_joint", "unknown joint 'knee_joint'"),
        ("stroke: 0.085", "stroke: -1.0", "stroke"),
    ],
)
def test_an_arm_that_does_not_fit_its_urdf_is_refused(tmp_path: Path, old: str, new: str, words: str) -> None:
    with pytest.raises(WorldError) as refused:
        load_world(world_with(tmp_path, old, new))
    assert words in str(refused.value)


def test_a_joint_that_cannot_move_is_refused(tmp_path: Path) -> None:
    path = world_with(tmp_path)
    urdf = (tmp_path / "ur10e.urdf").read_text()
    (tmp_path / "ur10e.urdf").write_text(re.sub(r'velocity="[^"]*"', 'velocity="0"', urdf, count=1))
    with pytest.raises(WorldError, match=r"missing limit .*`velocity` of a joint"):
        load_world(path)

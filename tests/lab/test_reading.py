"""Lab files, valid and invalid ones."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.errors import UsageError
from seoro.lab.reading import read_lab

GOOD = """simulators:
  hall: {simulator: mujoco, world: hall}
bridges:
  floor: {connect: tcp/127.0.0.1:7460}
robots:
  leader: {in: floor, as: turtlebot4}
  follower: {in: hall, as: turtlebot4_2}
"""


def written(folder: Path, text: str) -> Path:
    file = folder / "lab.yaml"
    file.write_text(text)
    return file


def test_a_lab_file_lists_nodes_and_the_places_of_robots(tmp_path: Path) -> None:
    lab = read_lab(written(tmp_path, GOOD))
    assert lab.simulator is not None
    assert lab.simulator[1].simulator == "mujoco"
    assert lab.world == "hall"
    assert lab.bridges["floor"].connect == "tcp/127.0.0.1:7460"
    assert (lab.robots["follower"].where, lab.robots["follower"].name_there) == ("hall", "turtlebot4_2")
    assert lab.position_of("follower") == f"{tmp_path}/lab.yaml:7"


def test_paths_of_worlds_are_relative_to_the_lab_file(tmp_path: Path) -> None:
    lab = read_lab(written(tmp_path, "simulators:\n  hall: {simulator: mujoco, world: worlds/hall.yaml}\n"))
    assert lab.world == str(tmp_path / "worlds" / "hall.yaml")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("robots: [", r"lab\.yaml:1: invalid YAML"),
        ("{}", r"lab\.yaml:1: the lab has neither a simulator nor a bridge"),
        ("just words", r"lab\.yaml:1: the file: "),
        (
            "bridge:\n  floor: {connect: x}\n",
            r"lab\.yaml:1: bridge: unknown key `bridge` \(did you mean",
        ),
        ("bridges:\n  floor: {at: x}\n", r"lab\.yaml:2: bridges\.floor\.connect: Field required"),
        ("simulators:\n  hall: {world: hall}\n", r"lab\.yaml:2: simulators\.hall: .* either `simulator`"),
        ("simulators:\n  hall: {simulator: mujoco, connect: x}\n", r"lab\.yaml:2: .* either"),
        ("simulators:\n  a: {simulator: mujoco}\n  b: {simulator: mujoco}\n", r"lab\.yaml:3: .* one simulator"),
        (f"{GOOD}  third: {{in: flor, as: x}}\n", r"lab\.yaml:8: .* 'flor' \(simulators and .*: floor, hall"),
        (
            f"{GOOD}  third: {{in: floor, as: turtlebot4}}\n",
            r"lab\.yaml:8: .*: duplicate robot, also of leader",
        ),
        (
            "simulators:\n  a: {simulator: mujoco}\nbridges:\n  a: {connect: x}\n",
            r"lab\.yaml:4: .* duplicate name, also of a simulator",
        ),
    ],
)
def test_invalid_lab_files_are_reported_with_file_and_line(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        read_lab(written(tmp_path, text))


def test_a_missing_lab_file_is_reported(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match=r"cannot read .*none\.yaml"):
        read_lab(tmp_path / "none.yaml")

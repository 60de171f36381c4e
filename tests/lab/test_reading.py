"""Lab files: what they may say, and what is said of those that are wrong."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.errors import InvalidUse
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


def test_a_lab_says_what_there_is_and_who_lives_where(tmp_path: Path) -> None:
    lab = read_lab(written(tmp_path, GOOD))
    assert lab.simulator is not None
    assert lab.simulator[1].simulator == "mujoco"
    assert lab.world == "hall"
    assert lab.bridges["floor"].connect == "tcp/127.0.0.1:7460"
    assert (lab.robots["follower"].where, lab.robots["follower"].called) == ("hall", "turtlebot4_2")
    assert lab.place("follower") == f"{tmp_path}/lab.yaml:7"


def test_worlds_in_files_lie_beside_the_lab(tmp_path: Path) -> None:
    lab = read_lab(written(tmp_path, "simulators:\n  hall: {simulator: mujoco, world: worlds/hall.yaml}\n"))
    assert lab.world == str(tmp_path / "worlds" / "hall.yaml")


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("robots: [", r"lab\.yaml:1: no valid YAML"),
        ("{}", r"lab\.yaml:1: the lab has neither a simulator nor a bridge"),
        ("just words", r"lab\.yaml:1: the file: "),
        (
            "bridge:\n  floor: {connect: x}\n",
            r"lab\.yaml:1: bridge: unknown key `bridge` \(did you mean",
        ),
        ("bridges:\n  floor: {at: x}\n", r"lab\.yaml:2: bridges\.floor\.connect: Field required"),
        ("simulators:\n  hall: {world: hall}\n", r"lab\.yaml:2: simulators\.hall: .* which `simulator` to start"),
        ("simulators:\n  hall: {simulator: mujoco, connect: x}\n", r"lab\.yaml:2: .* either"),
        ("simulators:\n  a: {simulator: mujoco}\n  b: {simulator: mujoco}\n", r"lab\.yaml:3: .* one simulator"),
        (f"{GOOD}  third: {{in: flor, as: x}}\n", r"lab\.yaml:8: .* 'flor' in this lab: there are floor, hall"),
        (
            f"{GOOD}  third: {{in: floor, as: turtlebot4}}\n",
            r"lab\.yaml:8: .*: leader lives in that robot already",
        ),
        ("simulators:\n  a: {simulator: mujoco}\nbridges:\n  a: {connect: x}\n", r"lab\.yaml:4: .* called a, too"),
    ],
)
def test_what_is_wrong_is_said_with_file_and_line(tmp_path: Path, text: str, words: str) -> None:
    with pytest.raises(InvalidUse, match=words):
        read_lab(written(tmp_path, text))


def test_a_lab_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InvalidUse, match=r"cannot read .*none\.yaml"):
        read_lab(tmp_path / "none.yaml")

"""`seoro sim inspect`: descriptions of robots by their models and declarations."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from sim_nodes.__main__ import main
from sim_nodes.robots.reading import read_robot
from tests.sim_nodes import robots_of_makers as makers


def printed(capsys: pytest.CaptureFixture[str], *arguments: str, status: int = 0) -> str:
    assert main(["inspect", *arguments]) == status
    out, errors = capsys.readouterr()
    return out if not status else out + errors


@pytest.fixture
def robot(tmp_path: Path) -> str:
    makers.write_robot(tmp_path, makers.two_wheels(extra=makers.LIDAR), "differential")
    return str(tmp_path / "robot.urdf")


def test_a_model_is_described(robot: str, capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, robot)
    assert text.startswith("maker: 9.114 kg, 5 links, 3 joints that move\n")
    for words in (
        "LINK     MASS [kg]  SOLID SHAPES",
        "declaration (derived from the model)",
        "wheel_radius: 0.08",
    ):
        assert words in text
    assert "swivel       continuous  caster  -     -   -       -" in text
    assert "new link 'base_footprint'" in text


def test_the_printed_declaration_loads(robot: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, robot, "--declaration")
    assert text.startswith(f"model: maker\nurdf: {robot}\ndrive: differential\n")
    short, long = tmp_path / "short.yaml", tmp_path / "long.yaml"
    short.write_text(text)
    long.write_text(text.replace("\n# ", "\n").replace("Values from", "# Values from"))  # all values declared
    assert read_robot(long) == read_robot(short)


def test_an_inspection_is_json(robot: str, capsys: pytest.CaptureFixture[str]) -> None:
    content = json.loads(printed(capsys, robot, "--json"))
    assert (content["drive"], content["root"], content["is_derived"]) == ("differential", "chassis", True)
    assert content["declaration"]["mobile"]["lidar"]["link"] == "top"
    assert {joint["name"]: joint["velocity"] for joint in content["joints"]}["left_joint"] == 10.0
    assert content["joints"][0]["lower"] is None


def test_declared_robots_are_described(capsys: pytest.CaptureFixture[str]) -> None:
    assert "wheel_separation: 0.233" in printed(capsys, "turtlebot4")
    assert "tool_link: tcp" in printed(capsys, "ur10e")


def test_contradictions_are_problems(robot: str, capsys: pytest.CaptureFixture[str]) -> None:
    text = printed(capsys, robot, "--drive", "ackermann", status=1)
    assert "problems\n  found 2 driven wheels for the drive `ackermann`; expected 3 or more" in text
    assert "found 2 driven wheels" in printed(capsys, robot, "--drive", "ackermann", "--declaration", status=1)


def test_a_model_without_wheels_has_no_declaration(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "robot.urdf"
    path.write_text(makers.two_wheels(wheel='<box size="0.1 0.1 0.3"/>'))
    assert "found no wheels: round links on the floor" in printed(capsys, str(path))
    assert "found no wheels in" in printed(capsys, str(path), "--declaration", status=1)
    assert "cannot read none.urdf" in printed(capsys, "none.urdf", status=2)

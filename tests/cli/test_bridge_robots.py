"""`seoro bridge ros2 --robot`: its options."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges.ros2.wire import Ros2Dds
from seoro.cli.exit_status import Exit
from seoro.cli.main import main
from seoro.errors import UsageError


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "`--robot` serves ROS 2 robots to runs"),
        (["--robot", "turtlebot4", "--expose"], "`--robot` serves ROS 2 robots to runs"),
        (["--robot", "rover"], "profiles: "),
        (["--robot", "turtlebot4:1"], "for example `--robot turtlebot4:leader@/tb1`"),
        (["--robot", "turtlebot4", "--robot", "turtlebot4"], "duplicate robot name 'turtlebot4'"),
        (
            ["--robot", "turtlebot4:a@/tb", "--robot", "turtlebot4:b@/tb/"],
            "'a' and 'b' are the same robot: both are commanded by /tb/cmd_vel",
        ),
        (["--robot", "turtlebot4@/1tb"], "1tb"),
        (["--robot", "turtlebot4@x//y"], "invalid namespace in `--robot turtlebot4@x//y`: 'x//y': empty part"),
        (["--robot", "turtlebot4", "--name", "Hall"], "invalid name 'Hall' of a bridge"),
        (["--robot", "turtlebot4", "--ros-listen", "tcp/127.0.0.1:1"], "`--ros-listen` needs `--expose`"),
        (["--expose", "--dialect", "ros2dds"], "`--dialect` needs `--robot`"),
    ],
)
def test_invalid_options_are_rejected(
    capsys: pytest.CaptureFixture[str], arguments: list[str], words: str
) -> None:
    assert main(["bridge", "ros2", *arguments]) == Exit.INVALID
    assert words in capsys.readouterr().err


def test_profiles_are_wrong_with_their_line(capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    profile = tmp_path / "rover.yaml"
    profile.write_text("model: rover\nkinds: [robot]\nbase:\n  limits: {linear: -1, angular: 1}\n")
    assert main(["bridge", "ros2", "--robot", str(profile)]) == Exit.INVALID
    assert f"{profile}:4: base.limits.linear: Input should be greater than 0" in capsys.readouterr().err


def test_an_unreachable_router_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["bridge", "ros2", "--robot", "turtlebot4", "--ros", "tcp/127.0.0.1:1"]) == Exit.ERROR
    assert "cannot connect to tcp/127.0.0.1:1" in capsys.readouterr().err


@pytest.mark.parametrize(("arguments", "dialect"), [([], None), (["--dialect", "ros2dds"], Ros2Dds())])
def test_the_dialect_option_reaches_the_connection(
    monkeypatch: pytest.MonkeyPatch, arguments: list[str], dialect: Ros2Dds | None
) -> None:
    dialects: list[object] = []

    def connect(endpoint: str, *, dialect: object, **_: object) -> object:
        dialects.append(dialect)
        raise UsageError("not in this test")

    monkeypatch.setattr("seoro.bridges.ros2.participant.connect", connect)
    assert main(["bridge", "ros2", "--robot", "turtlebot4", *arguments]) == Exit.INVALID
    assert dialects == [dialect]

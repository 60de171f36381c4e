"""The options by which runs reach ROS 2 systems."""

import argparse
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.addresses import ROUTER
from seoro.cli.main import main
from seoro.cli.run_arguments import add_run_arguments, ros_of
from seoro.embed.options import Ros
from seoro.errors import InvalidUse


def read(*arguments: str) -> Ros | None:
    parser = argparse.ArgumentParser()
    add_run_arguments(parser)
    return ros_of(parser.parse_args(arguments))


def test_endpoint_domain_and_dialect_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    assert read() is None
    assert read("--ros") == Ros(ROUTER, interfaces=[])
    assert read("--ros", "tcp/10.0.0.1:7447?domain=3&dialect=ros2dds", "--ros-interfaces", "mine") == Ros(
        "tcp/10.0.0.1:7447", 3, "ros2dds", [Path("mine")]
    )
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    assert read("--ros") == Ros(ROUTER, 7, interfaces=[])
    assert read("--ros", "tcp/a:1?domain=0") == Ros("tcp/a:1", 0, interfaces=[])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("--ros", "tcp/a:1?domain=x"), "from 0 to 232, not 'x'"),
        (("--ros", "tcp/a:1?domain=233"), "from 0 to 232, not '233'"),
        (("--ros", "tcp/a:1?domian=1"), "is not of the form ENDPOINT"),
        (("--ros", "?domain=1"), "is not of the form ENDPOINT"),
        (("--ros-interfaces", "mine"), "is for a ROS 2 system, and there is none"),
    ],
)
def test_what_cannot_be_is_said(given: tuple[str, ...], message: str) -> None:
    with pytest.raises(InvalidUse, match=message):
        read(*given)


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["--ros", "tcp/127.0.0.1:9"], 3, "cannot connect to tcp/127.0.0.1:9: no router"),
        (["--ros", "tcp/127.0.0.1:9", "--clock", "virtual"], 2, "does not wait for the clock 'virtual'"),
        (["--ros", "tcp/127.0.0.1:9?dialect=dds"], 2, "there is no dialect 'dds'"),
        (["--ros", "tcp/127.0.0.1:9", "--ros-interfaces", "nowhere"], 2, "nowhere"),
    ],
)
def test_what_does_not_work_is_said_before_the_run(
    arguments: list[str], status: int, message: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "main.osc"
    file.write_text("import osc.ros\nscenario main:\n    do wait elapsed(1s)\n")
    assert main(["exec", str(file), *arguments]) == status
    error = capsys.readouterr().err
    assert message in error
    assert "internal error" not in error


def test_one_robot_carries_out_one_run_at_a_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "main.osc"
    file.write_text("import osc.types\nscenario main:\n    do wait elapsed(1s)\n")
    assert main(["sweep", str(file), "--ros", "--jobs", "2", "-o", str(tmp_path / "out")]) == 2
    assert "one robot carries out one run at a time" in capsys.readouterr().err


def test_runs_that_reach_a_ros_system_get_the_faster_event_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loops: list[dict[str, Any]] = []

    def run(main: object, *, backend_options: dict[str, Any]) -> int:
        loops.append(backend_options)
        return 0

    monkeypatch.setattr(anyio, "run", run)
    file = tmp_path / "main.osc"
    file.write_text("scenario main:\n    event done\n")
    assert main(["exec", str(file), "--ros"]) == main(["exec", str(file)]) == 0
    assert loops == [{"use_uvloop": True}, {"use_uvloop": False}]

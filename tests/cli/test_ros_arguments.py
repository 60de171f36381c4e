"""The options by which runs reach ROS 2 systems."""

from __future__ import annotations

import argparse
import asyncio
from collections.abc import Coroutine
from pathlib import Path
from typing import Any

import pytest
import uvloop

from seoro.bridges.addresses import ROS_ROUTER
from seoro.cli.main import main
from seoro.cli.run_arguments import add_run_arguments, ros_of
from seoro.embed.options import Ros
from seoro.errors import UsageError


def read(*arguments: str) -> Ros | None:
    parser = argparse.ArgumentParser()
    add_run_arguments(parser)
    return ros_of(parser.parse_args(arguments))


def test_endpoint_domain_and_dialect_are_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("ROS_DOMAIN_ID", raising=False)
    assert read() is None
    assert read("--ros") == Ros(ROS_ROUTER, interfaces=[])
    assert read("--ros", "tcp/10.0.0.1:7447?domain=3&dialect=ros2dds", "--ros-interfaces", "mine") == Ros(
        "tcp/10.0.0.1:7447", 3, "ros2dds", [Path("mine")]
    )
    monkeypatch.setenv("ROS_DOMAIN_ID", "7")
    assert read("--ros") == Ros(ROS_ROUTER, 7, interfaces=[])
    assert read("--ros", "tcp/a:1?domain=0") == Ros("tcp/a:1", 0, interfaces=[])


@pytest.mark.parametrize(
    ("given", "message"),
    [
        (("--ros", "tcp/a:1?domain=x"), "invalid domain ID 'x': expected 0 to 232"),
        (("--ros", "tcp/a:1?domain=233"), "invalid domain ID '233': expected 0 to 232"),
        (("--ros", "tcp/a:1?domian=1"), r"expected ENDPOINT\?domain=N"),
        (("--ros", "?domain=1"), r"expected ENDPOINT\?domain=N"),
        (("--ros-interfaces", "mine"), "needs a ROS 2 system"),
    ],
)
def test_invalid_arguments_are_rejected(given: tuple[str, ...], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        read(*given)


@pytest.mark.parametrize(
    ("arguments", "status", "message"),
    [
        (["--ros", "tcp/127.0.0.1:9"], 3, "cannot connect to tcp/127.0.0.1:9: no router"),
        (["--ros", "tcp/127.0.0.1:9", "--clock", "virtual"], 2, "the clock 'virtual' is impossible with"),
        (["--ros", "tcp/127.0.0.1:9?dialect=dds"], 2, "unknown dialect 'dds'"),
        (["--ros", "tcp/127.0.0.1:9", "--ros-interfaces", "nowhere"], 2, "nowhere"),
    ],
)
def test_impossible_options_are_rejected_before_the_run(
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
    assert main(["campaign", "run", str(file), "--ros", "--jobs", "2", "-o", str(tmp_path / "out")]) == 2
    assert "runs on one robot are sequential" in capsys.readouterr().err


def test_runs_that_reach_a_ros_system_get_the_faster_event_loop(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    loops: list[object] = []

    class Runner:
        def __init__(self, *, loop_factory: object) -> None:
            loops.append(loop_factory)

        def __enter__(self) -> Runner:
            return self

        def __exit__(self, *_: object) -> None:
            pass

        def run(self, main: Coroutine[Any, Any, Any]) -> int:
            main.close()
            return 0

    monkeypatch.setattr(asyncio, "Runner", Runner)
    file = tmp_path / "main.osc"
    file.write_text("scenario main:\n    event done\n")
    assert main(["exec", str(file), "--ros"]) == main(["exec", str(file)]) == 0
    assert loops == [uvloop.new_event_loop, None]

"""`seoro bridge --expose`: rejected options and printed texts."""

from __future__ import annotations

import os
import signal
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.expose import running
from seoro.bridges.wire import SimulationState, SimulatorFeatures
from seoro.cli.main import main
from seoro.cli.signals import termination_signals

FEATURES = SimulatorFeatures(
    engine="mujoco",
    engine_version="3",
    version="0",
    features=(),
    spawn_formats=(),
    world="",
    available_worlds=(),
    robots=(),
    time=0.0,
    step=0.004,
    state=SimulationState.NO_WORLD,
)


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["ros2"], "expected either `--robot` or `--expose`"),
        (["ros1", "--expose"], "unknown value `ros1`"),
        (["ros2", "--expose", "--domain", "300"], "invalid domain ID '300': expected 0 to 232"),
        (["ros2", "--expose", "--ros", "a", "--ros-listen", "b"], "not allowed with"),
    ],
)
def test_wrong_command_lines_are_refused(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = main(["bridge", *arguments])
    except SystemExit as ended:
        status = int(ended.code or 0)
    assert status == 2
    assert words in capsys.readouterr().err


def test_a_missing_simulator_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    nowhere = f"unixsock-stream/{tmp_path}/nowhere"
    assert main(["bridge", "ros2", "--expose", "--simulator", nowhere, "--ros", nowhere]) == 2
    error = capsys.readouterr().err
    assert f"cannot connect to {nowhere}" in error
    assert "seoro sim mujoco" in error


def test_bridge_prints_the_exposed_simulator_and_the_endpoint(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    given: list[running.ExposeSettings] = []

    async def expose(settings: running.ExposeSettings, ready: Any) -> None:
        given.append(settings)
        ready(FEATURES)

    monkeypatch.setattr(running, "expose", expose)
    assert main(["bridge", "ros2", "--expose", "--ros-listen", "tcp/127.0.0.1:7447", "--domain", "3"]) == 0
    exposed = "mujoco with no world (no robots) is exposed to ROS 2 on tcp/127.0.0.1:7447\n"
    assert capsys.readouterr().out == exposed
    assert (given[0].router, given[0].domain) == (None, 3)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_end_it_in_order(number: signal.Signals, monkeypatch: pytest.MonkeyPatch) -> None:
    closed: list[bool] = []

    async def expose(_settings: running.ExposeSettings, _ready: Any) -> None:
        os.kill(os.getpid(), number)
        try:
            await anyio.sleep(60.0)
        finally:
            closed.append(True)

    monkeypatch.setattr(running, "expose", expose)
    assert main(["bridge", "ros2", "--expose"]) == 128 + number
    assert closed


def test_a_hangup_that_is_ignored_as_by_nohup_ends_nothing() -> None:
    before = signal.signal(signal.SIGHUP, signal.SIG_IGN)
    try:
        assert termination_signals() == (signal.SIGINT, signal.SIGTERM)
    finally:
        signal.signal(signal.SIGHUP, before)
    assert signal.SIGHUP in termination_signals()

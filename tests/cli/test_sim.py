"""`seoro sim`: start of the node, and rejected options."""

from __future__ import annotations

import os
from collections.abc import Sequence
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.cli.main import main

pytestmark = pytest.mark.engine("mujoco")


@pytest.fixture
def started(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """Arguments of the program that replaces this one, without the file for the emergency stop."""
    given: list[str] = []

    def replace(_: str, command: Sequence[str]) -> None:
        *others, option, file = command[3:]
        assert option == "--stop-file"
        assert Path(file).parent == tmp_path / "seoro" / "simulators"
        given.extend(others)
        raise SystemExit(0)

    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path))
    monkeypatch.setattr(os, "execv", replace)
    return given


@pytest.fixture
def snapshot(tmp_path: Path) -> Path:
    path = tmp_path / "here.snapshot"
    message = wire.Snapshot(
        format=wire.SNAPSHOT_FORMAT,
        version="1",
        engine="mujoco",
        engine_version="4",
        world="maze",
        seed=0,
        time=2.0,
        state=b"",
        digest="",
    )
    path.write_bytes(wire.encode(message))
    return path


@pytest.mark.parametrize(
    ("options", "given"),
    [
        ([], ["--world", "maze"]),
        (["--world", "hall", "--seed", "7"], ["--world", "hall", "--seed=7"]),
        (
            ["--listen", "tcp/[::]:0", "--rate", "max"],
            ["--world", "maze", "--listen=tcp/[::]:0", "--rate=max"],
        ),
    ],
)
def test_options_are_handed_on(started: list[str], options: list[str], given: list[str]) -> None:
    with pytest.raises(SystemExit):
        main(["sim", "mujoco", *options])
    assert started == ["mujoco", *given]


@pytest.mark.parametrize("named", [[], ["mujoco"]])
def test_a_snapshot_continues_in_the_simulator_that_saved_it(
    started: list[str], snapshot: Path, named: list[str]
) -> None:
    with pytest.raises(SystemExit):
        main(["sim", *named, "--from-snapshot", str(snapshot)])
    assert started == ["mujoco", "--from-snapshot", str(snapshot)]


@pytest.mark.usefixtures("started")
@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        ([], "missing name of a simulator"),
        (["--from-snapshot", "SNAPSHOT", "--world", "maze"], "`--world` contradicts `--from-snapshot`"),
        (["pybullet", "--from-snapshot", "SNAPSHOT"], "is a snapshot of mujoco, not of pybullet"),
        (["--from-snapshot", "nowhere"], "cannot read the snapshot nowhere"),
        (["mujoco", "--from-snapshot", __file__], "invalid snapshot"),
        (["muJoCo"], "unknown simulator 'muJoCo'"),
    ],
)
def test_contradictory_options_are_rejected(
    snapshot: Path, arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    given = [str(snapshot) if argument == "SNAPSHOT" else argument for argument in arguments]
    assert main(["sim", *given]) == 2
    assert words in capsys.readouterr().err


def test_an_invalid_rate_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["sim", "mujoco", "--rate", "fast"])
    assert ended.value.code == 2
    assert "expected a positive number, or max, found 'fast'" in capsys.readouterr().err


def test_a_robot_is_inspected_by_the_node(monkeypatch: pytest.MonkeyPatch) -> None:
    given: list[str] = []

    def replace(_: str, command: Sequence[str]) -> None:
        given.extend(command[1:])
        raise SystemExit(0)

    monkeypatch.setattr(os, "execv", replace)
    with pytest.raises(SystemExit):
        main(["sim", "inspect", "robot.urdf", "--drive", "ackermann", "--declaration"])
    assert given == ["-m", "sim_nodes", "inspect", "robot.urdf", "--drive=ackermann", "--declaration"]


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (["inspect"], "missing model to inspect"),
        (["mujoco", "robot.urdf"], "unexpected argument `robot.urdf`"),
        (["mujoco", "--json"], "unexpected argument `--json`"),
    ],
)
def test_arguments_of_inspections_are_checked(
    arguments: list[str], words: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sim", *arguments]) == 2
    assert words in capsys.readouterr().err

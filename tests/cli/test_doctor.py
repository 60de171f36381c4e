"""`seoro doctor` on the command line."""

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.executors import NAME, RunningExecutor, executor


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("x")) as running:
        yield running


def test_the_path_to_an_executor_is_checked_step_by_step(
    lab: RunningExecutor, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["doctor", "--on", NAME, "--executor", lab.endpoint]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("ok       seoro:") for line in lines)
    assert any(f"{NAME}: latency" in line for line in lines)
    assert lines[-1].startswith("0 failed, ")


def test_programs_get_json(lab: RunningExecutor, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--json", "--executor", lab.endpoint]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {"what", "status", "message", "help"} == set(found[0])
    assert {each["status"] for each in found} <= {"ok", "warning"}


def test_failed_checks_set_the_exit_status(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--executor", "unixsock-stream//nowhere/hub"]) == 1
    out = capsys.readouterr().out
    assert "failed   endpoint: socket not found: /nowhere/hub" in out
    assert "= help: start an executor there with `seoro serve`" in out


def test_a_missing_executor_is_ok_unless_requested(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("SEORO_EXECUTOR", raising=False)
    monkeypatch.setattr("seoro.cli.doctor_command.EXECUTOR", "unixsock-stream//nowhere/hub")
    assert main(["doctor"]) == 0
    assert "none was requested" in capsys.readouterr().out


def test_a_lab_file_is_looked_at_from_the_file_itself_on(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("SEORO_EXECUTOR", raising=False)
    monkeypatch.setattr("seoro.cli.doctor_command.EXECUTOR", "unixsock-stream//nowhere/hub")
    file = tmp_path / "lab.yaml"
    file.write_text("bridges:\n  floor: {connect: unixsock-stream//nowhere/floor}\nrobots:\n  tb: {in: flor}\n")
    assert main(["doctor", "--lab", str(file)]) == 1
    assert f"failed   lab file: {file}:4: robots.tb: unknown simulator" in capsys.readouterr().out
    file.write_text(file.read_text().replace("flor}", "floor}"))
    monkeypatch.setenv("SEORO_LAB", str(file))
    assert main(["doctor"]) == 1
    out = capsys.readouterr().out
    assert "failed   floor (unixsock-stream//nowhere/floor): socket not found: /nowhere/floor" in out
    assert "= help: start the node with `seoro sim` or `seoro bridge`" in out

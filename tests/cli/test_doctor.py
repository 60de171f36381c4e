"""`seoro doctor` on the command line."""

import json
from collections.abc import Iterator

import pytest

from seoro.cli.main import main
from tests.executors import NAME, RunningExecutor, executor


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("x")) as running:
        yield running


def test_the_way_to_an_executor_is_told_line_by_line(
    lab: RunningExecutor, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["doctor", "--on", NAME, "--executor", lab.endpoint]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("ok       seoro:") for line in lines)
    assert any(f"{NAME}: answers in" in line for line in lines)
    assert lines[-1].startswith("0 failed, ")


def test_programs_get_json(lab: RunningExecutor, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--json", "--executor", lab.endpoint]) == 0
    found = json.loads(capsys.readouterr().out)
    assert {"what", "status", "message", "help"} == set(found[0])
    assert {each["status"] for each in found} <= {"ok", "warning"}


def test_what_has_failed_is_in_the_exit_status(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["doctor", "--executor", "unixsock-stream//nowhere/hub"]) == 1
    out = capsys.readouterr().out
    assert "failed   endpoint: there is no socket /nowhere/hub" in out
    assert "= help: start an executor there with `seoro serve`" in out


def test_no_executor_is_no_fault_if_none_was_asked_for(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.delenv("SEORO_EXECUTOR", raising=False)
    monkeypatch.setattr("seoro.cli.doctor_command.ENDPOINT", "unixsock-stream//nowhere/hub")
    assert main(["doctor"]) == 0
    assert "none was asked for" in capsys.readouterr().out

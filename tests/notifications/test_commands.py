"""Notifications of commands, also of interrupted and invalid runs, campaigns and tests."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.notifications.hooks import Hook, hooked

FAILING = 'import osc.helpers\nscenario failing:\n    do serial:\n        log("x")\n        emit fail\n'
WAITING = "import osc.types\nscenario waiting:\n    do wait elapsed(3600s)\n"
VARYING = """import osc.types
import osc.helpers

scenario varying:
    size: int
    keep(size in [1, 2, 3])
    do serial:
        wait size < 3
"""


def _write(folder: Path, text: str) -> Path:
    path = folder / "main.osc"
    path.write_text(text)
    return path


def test_a_run_is_notified_with_its_result(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = _write(tmp_path, FAILING)
    with hooked(Hook()) as first, hooked(Hook(statuses=(403,))) as second:
        out = str(tmp_path / "out")
        arguments = ["exec", str(file), "--seed", "5", "-o", out, "--notify", first.url, "--notify", second.url]
        assert main(arguments) == 1
        assert main([*arguments, "--dry-run"]) == 0
    [message] = first.messages
    run = message["run"]
    assert (run["status"], run["reason"], run["scenario"], run["seed"]) == ("failed", "`emit fail`", "failing", 5)
    assert run["folder"] == out
    assert "warning: notification not delivered: http://127.0.0.1" in capsys.readouterr().err


def test_what_cannot_be_run_is_notified(tmp_path: Path) -> None:
    file = _write(tmp_path, "scenario broken:\n    do missing()\n")
    with hooked(Hook()) as hook:
        assert main(["exec", str(file), "--notify", hook.url]) == 2
    assert hook.messages[0]["run"]["status"] == "invalid"


def test_an_invalid_url_is_refused_before_the_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", str(_write(tmp_path, FAILING)), "--notify", "http://example.org/secret"]) == 2
    error = capsys.readouterr().err
    assert "SEORO_NOTIFY_HTTP=1" in error
    assert "secret" not in error


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_an_interrupted_run_is_notified(tmp_path: Path, number: signal.Signals) -> None:
    file = _write(tmp_path, WAITING)
    with hooked(Hook()) as hook:
        command = [sys.executable, "-m", "seoro", "exec", str(file), "--notify", hook.url]
        process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
        assert process.stdout is not None
        assert "seed" in process.stdout.readline()
        process.send_signal(number)
        process.communicate()
    assert hook.messages[0]["run"]["status"] == "cancelled"
    assert process.returncode == (130 if number == signal.SIGINT else 4)


def test_a_project_names_urls(tmp_path: Path) -> None:
    file = _write(tmp_path, FAILING)
    with hooked(Hook()) as hook:
        (tmp_path / "seoro.toml").write_text(f'notify = ["{hook.url}"]\n')
        assert main(["exec", str(file)]) == 1
    assert hook.messages[0]["run"]["status"] == "failed"


def test_urls_of_a_project_are_never_shown(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = _write(tmp_path, FAILING)
    for value in ('"https://token@example.org"', '["ftp://token@example.org"]', '["https://token@example.org"]'):
        (tmp_path / "seoro.toml").write_text(f"notify = {value}\n")
        assert main(["config", str(file)]) in (0, 2, None)
        if "ftp" in value:
            assert main(["exec", str(file)]) == 2
        shown = capsys.readouterr()
        assert "notify" in shown.out + shown.err
        assert "token" not in shown.out + shown.err


def test_an_interrupted_campaign_is_notified(tmp_path: Path) -> None:
    file = _write(tmp_path, WAITING)
    with hooked(Hook()) as hook:
        command = [sys.executable, "-m", "seoro", "campaign", "run", str(file), "-o", str(tmp_path / "out")]
        options = ["--strategy", "random", "--runs", "2", "--notify", hook.url]
        process = subprocess.Popen([*command, *options], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert process.stdout is not None
        assert "seed" in process.stdout.readline()
        process.send_signal(signal.SIGINT)
        process.communicate()
    [message] = hook.messages
    assert (message["campaign"]["status"], message["campaign"]["is_complete"]) == ("cancelled", False)
    assert process.returncode == 130


def test_a_campaign_is_notified_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    file = _write(tmp_path, VARYING)
    out = str(tmp_path / "campaign")
    options = ["--clock", "virtual", "--seed", "1", "--strategy", "random", "--runs", "4"]
    with hooked(Hook()) as hook:
        status = main(["campaign", "run", str(file), "-o", out, *options, "--notify", hook.url])
        assert main(["campaign", "resume", out, "--runs", "6", "--notify", hook.url]) == status
    first, second = (each["campaign"] for each in hook.messages)
    assert (first["runs"], first["planned"], first["is_complete"]) == (4, 4, True)
    assert (second["runs"], second["folder"]) == (6, out)
    assert first["status"] == {0: "passed", 1: "failed", 3: "error"}[status]
    assert sum(first["ends"].values()) == 4
    assert set(first["rate"]) == {"share", "low", "high"}


def test_tests_are_notified_once(tmp_path: Path) -> None:
    _write(tmp_path, FAILING)
    (tmp_path / "passing.osc").write_text('import osc.helpers\nscenario passing:\n    do log("x")\n')
    with hooked(Hook()) as hook:
        command = [sys.executable, "-m", "seoro", "test", ".", "--notify", hook.url]
        environment = {name: text for name, text in os.environ.items() if not name.startswith("PYTEST")}
        done = subprocess.run(
            command, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False, timeout=120
        )
    assert done.returncode == 1, done.stdout + done.stderr
    [message] = hook.messages
    assert (message["test"]["passed"], message["test"]["failed"]) == (1, 1)
    assert "failing" in message["test"]["failures"][0]

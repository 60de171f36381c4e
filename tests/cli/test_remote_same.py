"""`seoro exec --on` gives the same output and files as a local run, except for times."""

from __future__ import annotations

import re
import shutil
import signal
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

from seoro.cli.follower import LONGEST, LineBuffer
from seoro.cli.main import main
from tests.cli.test_live_tree import in_a_terminal, read_until
from tests.executors import NAME, RunningExecutor, executor

SCENARIOS = Path(__file__).parents[2] / "scenarios"
INVALID = "import osc.helpers\nscenario main:\n    do serial:\n        log(3)\n        nothing()\n"
LATE = """import osc.helpers
scenario main:
    timeout(2s)
    event go
    count: int = 3
    do serial:
        log("a")
        wait @go
"""
PROGRAMS = """import osc.helpers
scenario main:
    do serial:
        run_process("echo one")
        run_process("sh -c 'echo bad >&2; exit 3'")
"""
NOISY = """import osc.noisy
import osc.helpers
scenario main:
    do serial:
        make_noise()
        wait elapsed(60s)
"""
NOISE = """import sys
from seoro import ActionContext, action

@action("make_noise")
async def make_noise(ctx: ActionContext) -> None:
    print("one\\x1b[2J")
    sys.stderr.write("two\\nthree")
    sys.stderr.flush()
"""


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("x"), "--allow", "python", "--allow", "run_process") as running:
        yield running


@pytest.fixture(autouse=True)
def _here(lab: RunningExecutor, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SEORO_EXECUTOR", lab.endpoint)


def without_times(text: str) -> str:
    """A text without times of the machine's clock."""
    return re.sub(r'[\d.]+ s real|"(wall|wall_duration|clean_up)": ?[^,}]+|(time|timestamp)="[^"]*"', "?", text)


def said_and_left(
    arguments: list[str], capsys: pytest.CaptureFixture[str]
) -> tuple[int, str, str, dict[str, str]]:
    shutil.rmtree("out", ignore_errors=True)
    status = main(arguments)
    out, err = capsys.readouterr()
    left = {path.name: without_times(path.read_text()) for path in Path().glob("out/*")}
    return status, without_times(out), without_times(err), left


@pytest.mark.parametrize(
    ("scenario", "options", "status"),
    [
        (SCENARIOS / "coverage/lanes_and_speeds.osc", ["--clock", "virtual", "-o", "out"], 0),
        (INVALID, ["-o", "out", "--json"], 2),
        (LATE, ["--clock", "virtual", "-o", "out"], 1),
        (LATE, ["--clock", "virtual", "--junit", "out/junit.xml", "--trace", "-"], 1),
        (SCENARIOS / "navigation/obstacle.osc", ["--sim", "nonsense", "-o", "out"], 2),
        (SCENARIOS / "navigation/obstacle.osc", ["--clock", "real", "-o", "out"], 2),
    ],
)
def test_a_remote_run_equals_a_local_run(
    scenario: str | Path, options: list[str], status: int, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("test.osc").write_text(scenario if isinstance(scenario, str) else scenario.read_text())
    arguments = ["exec", "test.osc", "--seed", "3", *options]
    here = said_and_left(arguments, capsys)
    assert here[0] == status, here
    assert said_and_left([*arguments, "--on", NAME], capsys) == here


def test_imports_by_absolute_paths_give_the_same_run(capsys: pytest.CaptureFixture[str]) -> None:
    Path("common").mkdir()
    Path("common/more.osc").write_text("struct more\n")
    Path("common/late.osc").write_text('import "more.osc"\n' + LATE.replace("main", "late"))
    Path("test.osc").write_text(f'import "{Path.cwd()}/common/late.osc"\nscenario main:\n    do late()\n')
    arguments = ["exec", "test.osc", "--seed", "3", "--clock", "virtual", "-o", "out"]
    here = said_and_left(arguments, capsys)
    assert f"{Path.cwd()}/common/late.osc:4:5" in here[2]
    assert said_and_left([*arguments, "--on", NAME], capsys) == here


def test_output_of_programs_is_the_same(capsys: pytest.CaptureFixture[str]) -> None:
    Path("test.osc").write_text(PROGRAMS)
    arguments = ["exec", "test.osc", "--seed", "3"]
    (status, out, err, _), there = (said_and_left([*arguments, *where], capsys) for where in ([], ["--on", NAME]))
    assert status == 1
    stamps = r"\d+\.\d+ s"
    assert re.sub(stamps, "?", there[1]) == re.sub(stamps, "?", out)
    assert re.sub(stamps, "?", there[2]) == re.sub(stamps, "?", err)


def write_noise(scenario: str) -> None:
    Path("seoro.libraries").mkdir()
    Path("seoro.libraries/noisy.osc").write_text("action make_noise\n")
    Path("seoro.libraries/noisy.py").write_text(NOISE)
    Path("test.osc").write_text(scenario)


def test_output_of_an_action_is_below_the_live_tree() -> None:
    write_noise("import osc.noisy\nscenario main:\n    do make_noise()\n")
    with in_a_terminal(["test.osc", "--on", NAME, "--live-tree", "--seed", "7"], 80, 20) as (_, ours):
        shown = read_until(ours, b"passed")
    last = shown[shown.rindex(b"seed 7") :]
    assert last.index(b"make_noise") < last.index(b"one\xef\xbf\xbd[2J") < last.index(b"three")


def test_output_of_an_action_is_printed_at_once_and_again_by_attach(
    capsys: pytest.CaptureFixture[str],
) -> None:
    write_noise(NOISY)
    command = [sys.executable, "-m", "seoro", "exec", "test.osc", "--on", NAME]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        lines: list[str] = []
        while "two" not in (line := running.stdout.readline()):
            assert line, lines
            lines.append(line)
        running.send_signal(signal.SIGINT)
        rest = running.communicate(timeout=30)[0]
    assert "one\ufffd[2J\n" in lines
    assert "\nthree\n" in rest
    assert main(["ps", "--limit", "1"]) == 0
    run = capsys.readouterr().out.splitlines()[1].split()[0]
    assert main(["attach", run]) == 4
    assert "one\ufffd[2J\ntwo\n" in capsys.readouterr().out


@pytest.mark.more
def test_lines_are_put_together_of_parts() -> None:
    printed = LineBuffer()
    data = "grün\r\nblau".encode()
    for at in range(len(data)):
        printed.add(data[at : at + 1])
    assert printed.pop_lines() == ["grün"]
    assert printed.pop_lines(is_end=True) == ["blau"]
    printed.add(b"x" * (LONGEST + 1))
    assert [len(line) for line in printed.pop_lines()] == [LONGEST + 1]

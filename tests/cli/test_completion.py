"""Completion of command lines."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from seoro.cli.completion_command import SHELLS
from seoro.cli.main import main

SCENARIOS = """import osc.types
scenario drive:
    pause: time = 1s
    var count: int = 0
    do wait elapsed(pause)
scenario rest:
    duration: time = 1s
    do wait elapsed(duration)
"""


@pytest.fixture
def place(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Return the working directory: a file of two scenarios, and an executor of this user with a run."""
    (tmp_path / "two.osc").write_text(SCENARIOS)
    (tmp_path / "notes.txt").touch()
    (tmp_path / "state" / "seoro" / "lab-a" / "runs" / "3f2a").mkdir(parents=True)
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.chdir(tmp_path)
    return tmp_path


def completed(line: str, place: Path) -> list[str]:
    """Return the completions of a command line, as a shell asks for them."""
    answer = place / "answer"
    asked = {"_ARGCOMPLETE": "1", "_ARGCOMPLETE_STDOUT_FILENAME": str(answer), "_ARGCOMPLETE_SUPPRESS_SPACE": "1"}
    environment = {**os.environ, **asked, "COMP_LINE": line, "COMP_POINT": str(len(line))}
    subprocess.run([sys.executable, "-m", "seoro"], env=environment, check=True, timeout=60)
    return answer.read_text().split("\013")


@pytest.mark.parametrize(
    ("line", "expected"),
    [
        ("seoro ex", ["exec", "explain"]),
        ("seoro ros topic e", ["echo"]),
        ("seoro exec two.osc --clock ", ["real", "sim", "virtual"]),
        ("seoro exec two.osc --wor", ["--world"]),
        ("seoro exec t", ["two.osc"]),
        ("seoro exec n", []),
        ("seoro exec two.osc --scenario ", ["drive", "rest"]),
        ("seoro exec two.osc --set ", ["duration=", "pause="]),
        ("seoro exec two.osc --scenario rest --set ", ["duration="]),
        ("seoro exec two.osc --world maz", ["maze"]),
        ("seoro exec two.osc --on ", ["lab-a"]),
        ("seoro get ", ["3f2a"]),
        ("seoro explain E0312", ["E0312"]),
        ("seoro doc osc.nav", ["osc.nav2"]),
        ("seoro doc nav_to_po", ["nav_to_pose"]),
        ("seoro schema wo", ["world"]),
        ("seoro sim p", ["pybullet"]),
    ],
)
def test_options_files_and_names_are_completed(line: str, expected: list[str], place: Path) -> None:
    found = [each for each in completed(line, place) if each and (each[0] != "-" or "-" in line)]
    assert sorted(found) == expected


def test_bash_completes_by_the_script(place: Path) -> None:
    (place / "seoro").symlink_to(Path(sys.executable).with_name("seoro"))
    script = """
        source <(./seoro completion bash)
        COMP_LINE='seoro exec --wor'; COMP_POINT=16; COMP_TYPE=9
        _python_argcomplete ./seoro --wor exec
        printf '%s' "${COMPREPLY[@]}"
    """
    done = subprocess.run(["bash", "-c", script], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout == "--world "


@pytest.mark.skipif(shutil.which("fish") is None, reason="fish is not installed")
def test_fish_completes_by_the_script(place: Path) -> None:
    script = f"""
        set -x PATH {Path(sys.executable).parent} $PATH
        seoro completion fish | source
        complete -C 'seoro ex'
    """
    done = subprocess.run(["fish", "-c", script], capture_output=True, text=True, check=True, timeout=60)
    assert done.stdout.startswith("exec\trun a scenario")


@pytest.mark.parametrize("shell", SHELLS)
def test_each_shell_has_a_script(shell: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["completion", shell]) == 0
    assert "seoro" in capsys.readouterr().out

"""A new project passes at once, in processes of its own."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from seoro.cli.main import main
from seoro.cli.new_command import CI


def seoro(folder: Path, *arguments: str) -> str:
    """Run a command in a folder; returns its output."""
    environment = {name: value for name, value in os.environ.items() if not name.startswith("PYTEST_")}
    command = [sys.executable, "-m", "seoro", *arguments]
    done = subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, check=False, timeout=300
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout


def test_the_scenario_and_the_tests_of_a_new_project_pass(tmp_path: Path) -> None:
    seoro(tmp_path, "new", "warehouse")
    folder = tmp_path / "warehouse"
    assert "1 file checked: no errors" in seoro(folder, "check", "scenarios")
    assert "passed  deliver" in seoro(folder, "exec", "scenarios/deliver.osc", "--seed", "1")
    assert "3 passed" in seoro(folder, "test")
    assert (folder / "README.md").read_text().startswith("# warehouse\n")
    seoro(folder, "fmt", "--check", "scenarios", "libraries")
    subprocess.run([sys.executable, "-m", "ruff", "check", "--isolated", "--quiet", str(folder)], check=True)


@pytest.mark.parametrize(("service", "file"), [*CI.items(), ("none", None)])
def test_the_file_for_ci_runs_check_and_test(service: str, file: str | None, tmp_path: Path) -> None:
    folder = tmp_path / "x"
    assert main(["new", str(folder), "--ci", service]) == 0
    found = {path for path in CI.values() if (folder / path).exists()}
    assert found == ({file} if file else set())
    if file:
        text = (folder / file).read_text()
        assert '"$SEORO"' in text
        assert "seoro check" in text
        assert "seoro test" in text
        yaml.safe_load(text)


def test_a_folder_with_files_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "mine.txt").touch()
    assert main(["new", str(tmp_path)]) == 2
    assert "exists, and is not an empty folder" in capsys.readouterr().err
    assert [path.name for path in tmp_path.iterdir()] == ["mine.txt"]
    assert main(["new", str(tmp_path / "mine.txt")]) == 2
    (tmp_path / "empty").mkdir()
    assert main(["new", str(tmp_path / "empty")]) == 0

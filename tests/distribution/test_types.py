"""Type checkers read the types of the installed wheel, as those of a user do."""

from __future__ import annotations

import json
import re
import shutil
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.node_js import needs_node, npm

PYRIGHT = "pyright@1.1.414"
USER = Path(__file__).parent / "user"
Check = Callable[[str], dict[int, list[str]]]
"""Checks a file strictly; returns its errors by line."""

pytestmark = pytest.mark.more


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Return a folder outside of the source tree, with the files of a user."""
    return Path(shutil.copytree(USER, tmp_path_factory.mktemp("user"), dirs_exist_ok=True))


def by_mypy(folder: Path, python: Path) -> Check:
    def check(file: str) -> dict[int, list[str]]:
        options = ["--strict", "--config-file=", f"--python-executable={python}", f"--cache-dir={folder}/cache"]
        command = [sys.executable, "-m", "mypy", *options, file]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode in (0, 1), done.stdout + done.stderr
        found: dict[int, list[str]] = {}
        for number, message in re.findall(rf"^{file}:(\d+): error: (.*)$", done.stdout, re.MULTILINE):
            found.setdefault(int(number), []).append(message)
        assert found or done.returncode == 0, done.stdout
        return found

    return check


def by_pyright(folder: Path, python: Path) -> Check:
    npm(folder, "install", "--no-save", PYRIGHT)
    (folder / "pyrightconfig.json").write_text('{"typeCheckingMode": "strict"}')

    def check(file: str) -> dict[int, list[str]]:
        command = ["node_modules/.bin/pyright", "--outputjson", "--pythonpath", str(python), file]
        done = subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=False)
        assert done.returncode in (0, 1), done.stdout + done.stderr
        found: dict[int, list[str]] = {}
        for each in json.loads(done.stdout)["generalDiagnostics"]:
            found.setdefault(each["range"]["start"]["line"] + 1, []).append(each["message"])
        return found

    return check


@pytest.fixture(
    scope="module",
    params=[pytest.param(by_mypy, id="mypy"), pytest.param(by_pyright, id="pyright", marks=needs_node)],
)
def check(request: pytest.FixtureRequest, folder: Path, installed: Path) -> Check:
    """Return each type checker."""
    maker: Callable[[Path, Path], Check] = request.param
    return maker(folder, installed)


def test_a_program_with_the_public_interface_has_no_errors(check: Check) -> None:
    assert not check("program.py")


def test_wrong_uses_are_reported_each_at_its_line(check: Check) -> None:
    lines = (USER / "mistakes.py").read_text().splitlines()
    wrong = [number for number, line in enumerate(lines, 1) if "# wrong" in line]
    found = check("mistakes.py")
    assert not [lines[number - 1] for number in wrong if number not in found]


def test_the_types_are_those_of_the_wheel(installed: Path, tmp_path: Path) -> None:
    command = [str(installed), "-c", "import seoro, pathlib; print(pathlib.Path(seoro.__file__).parent)"]
    where = Path(subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True).stdout.strip())
    assert where.is_relative_to(installed.parents[1])
    assert (where / "py.typed").exists()
    assert (where.parent / "sim_nodes" / "py.typed").exists()

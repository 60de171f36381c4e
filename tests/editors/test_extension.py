"""The extension for VS Code: its own tests, with a stand-in for VS Code and the real `seoro`."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import pytest

from seoro.dap.launch import Launch
from tests.node_js import copy_source, needs_node, npm

ROOT = Path(__file__).parents[2]
EXTENSION = ROOT / "editors/vscode"


@needs_node
def test_the_tests_of_the_extension_pass() -> None:
    environment = {**os.environ, "SEORO": str(Path(sys.executable).with_name("seoro"))}
    command = ["node", "--test", "test/extension.test.cjs"]
    done = subprocess.run(
        command, cwd=EXTENSION, env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stdout
    assert "# skipped 0" in done.stdout


@needs_node
@pytest.mark.more
def test_the_extension_is_packaged(tmp_path: Path) -> None:
    shutil.copy(ROOT / "LICENSE", tmp_path)
    copy = copy_source(EXTENSION, tmp_path / "editors/vscode")
    shutil.copytree(ROOT / "seoro/files/schemas", tmp_path / "seoro/files/schemas")
    npm(copy, "install", "--no-package-lock")
    npm(copy, "run", "package")
    with zipfile.ZipFile(copy / "dist/seoro-osc.vsix") as package:
        names = set(package.namelist())
        script = package.read("extension/dist/extension.js").decode()
    expected = ("package.json", "dist/extension.js", "syntaxes/osc.tmLanguage.json", "LICENSE.txt")
    assert names >= {f"extension/{name}" for name in expected}
    assert not any("test" in name or "node_modules" in name for name in names)
    assert "seoro.stepToInstant" in script
    assert "World file of seoro" in script


def test_each_command_of_the_extension_is_registered() -> None:
    package = json.loads((EXTENSION / "package.json").read_text())
    source = "".join(path.read_text() for path in (EXTENSION / "src").glob("*.js"))
    declared = {each["command"] for each in package["contributes"]["commands"]}
    assert all(f'registerCommand("{command}"' in source for command in declared)


def test_settings_of_debugging_are_those_of_the_adapter() -> None:
    package = json.loads((EXTENSION / "package.json").read_text())
    attributes = package["contributes"]["debuggers"][0]["configurationAttributes"]["launch"]
    assert set(attributes["properties"]) == {field.alias or name for name, field in Launch.model_fields.items()}

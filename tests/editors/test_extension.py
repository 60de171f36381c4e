"""The extension for VS Code: its own tests, with a stand-in for VS Code and the real `seoro`."""

from __future__ import annotations

import json
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from seoro.dap.launch import Launch

ROOT = Path(__file__).parents[2]
EXTENSION = ROOT / "editors/vscode"
NODE = 20  # major version whose test runner the tests need


def _has_node() -> bool:
    node = shutil.which("node")
    if node is None:
        return False
    version = subprocess.run([node, "--version"], capture_output=True, text=True, check=True).stdout
    return int(version.removeprefix("v").partition(".")[0]) >= NODE


@pytest.mark.skipif(not _has_node(), reason=f"needs Node.js {NODE}")
def test_the_tests_of_the_extension_pass() -> None:
    environment = {**os.environ, "SEORO": str(Path(sys.executable).with_name("seoro"))}
    command = ["node", "--test", "test/extension.test.cjs"]
    done = subprocess.run(
        command, cwd=EXTENSION, env=environment, capture_output=True, text=True, timeout=120, check=False
    )
    assert done.returncode == 0, done.stdout
    assert "# skipped 0" in done.stdout


def test_each_command_of_the_extension_is_registered() -> None:
    package = json.loads((EXTENSION / "package.json").read_text())
    source = "".join(path.read_text() for path in (EXTENSION / "src").glob("*.js"))
    declared = {each["command"] for each in package["contributes"]["commands"]}
    assert all(f'registerCommand("{command}"' in source for command in declared)


def test_settings_of_debugging_are_those_of_the_adapter() -> None:
    package = json.loads((EXTENSION / "package.json").read_text())
    attributes = package["contributes"]["debuggers"][0]["configurationAttributes"]["launch"]
    assert set(attributes["properties"]) == {field.alias or name for name, field in Launch.model_fields.items()}

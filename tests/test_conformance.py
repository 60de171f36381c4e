"""Conformance cases that lie outside of this repository, where there are some.

`SEORO_CONFORMANCE` names a folder with a runner `run.py` and cases; by default it is `shared/conformance` beside
the repository. A case is a scenario whose first lines state the expected result. All are checked or run here in
this process, and traces have to be accepted; `python run.py --seoro seoro` there runs them by the command.
"""

from __future__ import annotations

import argparse
import asyncio
import importlib.util
import json
import os
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from seoro.cli import exec_command
from seoro.embed import accept, check_file, load, prepare
from seoro.embed.options import Options
from seoro.errors import InvalidScenario, UsageError
from seoro.lang.diagnostic import Severity
from tests.leftovers import leftovers  # noqa: F401 - a fixture, for all cases

LONGEST = 20_000  # records of a trace that is checked; one case is a loop without end
STARTS = 10_000  # of behaviors in one instant, instead of 200,000: one case runs into this limit
FOLDER = Path(os.environ.get("SEORO_CONFORMANCE") or Path(__file__).parents[2] / "shared/conformance")


def load_runner() -> ModuleType | None:
    """Return the runner of the cases, or None."""
    path = FOLDER / "run.py"
    if not path.is_file():
        return None
    specification = importlib.util.spec_from_file_location("seoro_conformance", path)
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules[specification.name] = module  # its dataclasses look themselves up there
    writes_bytecode, sys.dont_write_bytecode = sys.dont_write_bytecode, True  # nothing is left in that folder
    try:
        specification.loader.exec_module(module)
    finally:
        sys.dont_write_bytecode = writes_bytecode
    return module


RUNNER = load_runner()
CASES = RUNNER.find_cases() if RUNNER is not None else []


def name_of(path: Path) -> str:
    """The name of a case."""
    return path.relative_to(FOLDER.resolve()).as_posix()


def parameter(path: Path) -> Any:
    """A case as a parameter of a test."""
    return pytest.param(path, id=name_of(path))


def check(path: Path) -> Any:
    """Check a case and return the result."""
    assert RUNNER is not None
    found = check_file(path).checked.diagnostics
    errors = [found.primary.span for found in found if found.severity is Severity.ERROR]
    places = tuple((Path(span.file.name).resolve(), span.line) for span in errors)
    return RUNNER.Outcome("invalid" if errors else "valid", places)


async def run(path: Path) -> Any:
    """Run a case on the virtual clock with its arguments, and return the result."""
    assert RUNNER is not None
    asyncio.get_running_loop().set_debug(True)  # as PYTHONASYNCIODEBUG does; it reports misuse of the loop
    parser = argparse.ArgumentParser()
    exec_command.add_arguments(parser)
    arguments = parser.parse_args([str(path), "--seed", "0", *RUNNER.load_case(path).args])
    overrides = dict(setting.split("=", 1) for setting in arguments.set)
    options = Options(
        name=arguments.scenario,
        seed=arguments.seed,
        overrides=overrides,
        parameters=arguments.params,
        clock="virtual",
    )
    try:
        scenario = load(path)
        async with prepare(scenario, options) as started, started.running():
            records = [record async for record in started.trace()]
    except (InvalidScenario, UsageError) as error:
        return RUNNER.Outcome("invalid", detail=str(error))
    if len(records) < LONGEST:
        assert accept(scenario, json.loads(json.dumps(records))).violations == ()
    logs = [record for record in records if record["kind"] == "log" and record["level"] == "info"]
    end = records[-1]
    messages = tuple((record["t"], record["message"]) for record in logs)
    return RUNNER.Outcome(end["status"], (), messages, end["duration"], end["reason"])


@pytest.mark.skipif(RUNNER is None, reason="no conformance cases found")
@pytest.mark.parametrize("path", [parameter(path) for path in CASES])
async def test_a_conformance_case_has_its_expected_result(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    assert RUNNER is not None
    monkeypatch.setattr("seoro.runtime.execution.loops.STARTS", STARTS)
    case = RUNNER.load_case(path)
    assert RUNNER.compare(case, check(path) if case.is_check else await run(path)) == []

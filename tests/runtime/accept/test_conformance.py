"""The traces of conformance cases are accepted, where there are such cases (`tests/test_conformance.py`)."""

import argparse
import json
from pathlib import Path
from typing import Any

import pytest

from seoro.cli import exec_command
from seoro.embed import Options, Scenario, accept, load, prepare
from tests.test_conformance import FOLDER, RUNNER

LONGEST = 100_000  # records; one case is a loop without end
CASES = (
    [path for path in RUNNER.find_cases() if RUNNER.load_case(path).expect in ("passed", "failed")]
    if RUNNER is not None
    else []
)


async def trace_of(path: Path) -> tuple[Scenario, list[dict[str, Any]]]:
    """The trace of a case, run on the virtual clock with the arguments that it names."""
    assert RUNNER is not None
    parser = argparse.ArgumentParser()
    exec_command.add_arguments(parser)
    arguments = parser.parse_args([str(path), *RUNNER.load_case(path).args])
    overrides = dict(setting.split("=", 1) for setting in arguments.set)
    seed = 1 if arguments.seed is None else arguments.seed
    options = Options(name=arguments.scenario, seed=seed, overrides=overrides, clock="virtual")
    scenario = load(path)
    async with prepare(scenario, options) as run, run.running():
        return scenario, [record async for record in run.trace()]


@pytest.mark.slow
@pytest.mark.skipif(RUNNER is None, reason="there are no conformance cases here")
@pytest.mark.parametrize("path", CASES, ids=lambda path: path.relative_to(FOLDER).as_posix())
async def test_the_trace_of_a_case_is_accepted(path: Path) -> None:
    scenario, records = await trace_of(path)
    acceptance = accept(scenario, json.loads(json.dumps(records[:LONGEST])))
    assert acceptance.violations == ()

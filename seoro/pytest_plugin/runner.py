"""Running scenarios as tests, and reports of failures."""

from __future__ import annotations

import asyncio
import math
import shlex
import traceback
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Unpack

import anyio
import pytest

import seoro
from seoro.bridges.launch import is_installed
from seoro.cli.terminal import error_text
from seoro.embed import Scenario, load
from seoro.embed.api import start_with
from seoro.embed.directives import INVALID, Directives
from seoro.embed.options import ClockName, OptionFields, Simulator, options_from
from seoro.errors import BackendError, InvalidScenario, UsageError
from seoro.lang.projects import settings_around
from seoro.pytest_plugin import MARK
from seoro.runtime.explain.reasons import reason_text
from seoro.runtime.trace.jsonl import to_line
from seoro.runtime.verdict import Verdict

STOP_IF_LOST = 60.0  # [s] after which an executor stops the run of a test that has died
MAX_LOGS = 200  # in the report of a failed scenario


@dataclass(frozen=True)
class Case:
    """Scenario with one combination of parameters.

    Args:
        scenario: Scenario file.
        directives: Directives of the scenario.
        options: Options of the combination; they take precedence over the fixture.
        simulator: Name of the simulator to start; None for that of the fixture.
    """

    scenario: Scenario
    directives: Directives
    options: OptionFields
    simulator: str | None = None


@dataclass(frozen=True)
class Result:
    """Result of a scenario.

    Args:
        verdict: Verdict of the run.
        parameters: Chosen values of parameters.
        records: Trace of the run.
        fault: Exception in an action's code that ended the run, if any.
    """

    verdict: Verdict
    parameters: dict[str, object]
    records: Sequence[dict[str, Any]]
    fault: Exception | None

    @property
    def passed(self) -> bool:
        """Whether the scenario passed."""
        return self.verdict.passed

    @property
    def logs(self) -> list[str]:
        """Messages of the log."""
        return [record["message"] for record in self.records if record["kind"] == "log"]

    def __repr__(self) -> str:
        return f"<{self.verdict.scenario}: {self.verdict.status.value} {self.verdict.reason!r}>"


class RunScenario:
    """Function object of the fixture `osc_run`, which runs scenarios in Python tests.

    Args:
        item: The test.
        folder: Base folder of paths.
        options: Options of all runs.
        results: Folder for traces of runs that do not pass.
    """

    def __init__(self, item: pytest.Item, folder: Path, options: OptionFields, results: Path) -> None:
        self._item = item
        self._folder = folder
        self._options = options
        self._results = results

    def __call__(self, file: str | Path | Scenario, **options: Unpack[OptionFields]) -> Result:
        """Run a scenario to its end.

        Args:
            file: Scenario file, or result of `seoro.load`.
            options: Options of `seoro.start`; they take precedence over the fixture `osc_options`.

        Raises:
            InvalidScenario, UsageError, BackendError: The scenario cannot be run.
        """
        scenario = file if isinstance(file, Scenario) else load(self._folder / file)
        merged: OptionFields = {**self._options, **options}
        config = self._item.config
        result = _run(scenario, {"timeout": config.getoption("osc_timeout"), **merged}, config.getoption("osc_on"))
        _write_page(self._item, result)
        if not result.passed:
            _report(self._item, result, self._results)
        return result


def options_of(config: pytest.Config) -> OptionFields:
    """Return the options of runs from pytest's command line."""
    name, endpoint, world = (config.getoption(f"osc_{key}") for key in ("sim", "connect", "world"))
    clock: ClockName | None = config.getoption("osc_clock")
    seed: int | None = config.getoption("osc_seed")
    poses: float | None = config.getoption("osc_poses")
    options = OptionFields(clock=clock, seed=seed, poses=poses)
    if name is not None or endpoint is not None:
        options["simulator"] = Simulator(name=name, endpoint=endpoint, world=world)
    return options


def run_case(case: Case, item: pytest.Item, options: OptionFields, results: Path) -> None:
    """Run a scenario; fail the test with a report if it does not end as expected."""
    wanted, reason = case.directives.expect, case.directives.reason
    merged: OptionFields = {**options, **case.options}
    merged["overrides"] = {**options.get("overrides", {}), **case.options.get("overrides", {})}
    if case.options.get("parameters") is None and "parameters" in options:
        merged["parameters"] = options["parameters"]
    executor: str | None = item.config.getoption("osc_on")
    if case.simulator is not None and executor is None and not is_installed(case.simulator):
        pytest.skip(f"the simulator {case.simulator} is not installed")
    # The directive takes precedence over the option, which is for all files.
    if case.directives.timeout is None and merged.get("timeout") is None:
        merged["timeout"] = item.config.getoption("osc_timeout")
    if (mark := item.get_closest_marker(MARK)) is not None:
        _run_campaign(mark, case, merged, results)
        return
    outcome: Result | InvalidScenario | UsageError | BackendError
    try:
        merged["simulator"] = _simulator(case, merged)
        outcome = _run(case.scenario, merged, executor)
    except (InvalidScenario, UsageError, BackendError) as error:
        outcome = error
    match outcome:
        case Result(verdict=verdict):
            item.user_properties.append(("seed", verdict.seed))
            _write_page(item, outcome)
            if verdict.status.value != wanted or reason not in verdict.reason:
                _report(item, outcome, results)
                pytest.fail(_failure(case.directives, outcome, merged, executor), pytrace=False)
        case InvalidScenario() | UsageError() if wanted == INVALID and reason in str(outcome):
            pass
        case _:
            pytest.fail(error_text(outcome), pytrace=False)


def _run_campaign(mark: pytest.Mark, case: Case, options: OptionFields, results: Path) -> None:
    """Run the campaign of a scenario; fail the test with a report if too many runs fail."""
    from seoro.pytest_plugin.campaigns import run_scenario  # noqa: PLC0415 - for such tests only

    try:
        if case.directives.expect != "passed":
            raise UsageError(f"`# seoro: expect` contradicts the mark `{MARK}`", help="leave out one of them")
        options["simulator"] = _simulator(case, options)
    except UsageError as error:
        pytest.fail(error_text(error), pytrace=False)
    run_scenario(mark, case.scenario, options, results)


def _simulator(case: Case, options: OptionFields) -> Simulator | None:
    """Return the simulator of the directives, the fixture or the project, with the world of the directives.

    Raises:
        UsageError: A directive names a world without a simulator, or a setting of the project is invalid.
    """
    simulator, world = options.get("simulator"), case.directives.world
    if case.simulator is None and _is_open(options):
        name = settings_around(case.scenario.file.path).get("simulator")
        simulator = None if name is None else Simulator(name)
    if case.simulator is not None:
        simulator = replace(simulator or Simulator(), name=case.simulator, endpoint=None)
    if world is None:
        return simulator
    if simulator is None:
        raise UsageError(f"the world {world!r} needs a simulator", help="add --osc-sim mujoco")
    return replace(simulator, world=world)


def _run(scenario: Scenario, options: OptionFields, executor: str | None) -> Result:
    """Run a scenario to its end, in this process or on an executor."""
    with suppress(RuntimeError):
        asyncio.get_running_loop()
        raise UsageError(
            "`osc_run` cannot be called from a running event loop",
            help="use `async with seoro.start(scenario, **osc_options) as run: verdict = await run.result()`",
        )
    chosen: OptionFields = {**options, "keep_trace": True}
    settings = settings_around(scenario.file.path)
    if _is_open(options) and "simulator" not in settings and "lab" not in settings:
        chosen["clock"] = "virtual"
    if executor is not None:
        return asyncio.run(_run_remotely(scenario, executor, chosen))
    return asyncio.run(_run_to_end(scenario, chosen))


def _is_open(options: OptionFields) -> bool:
    """Return whether options leave the backends of actors to the file and its project."""
    return all(options.get(key) is None for key in ("clock", "simulator", "lab", "ros"))


async def _run_to_end(scenario: Scenario, options: OptionFields) -> Result:
    async with start_with(scenario, options_from(options), "--osc-timeout SECONDS") as run:
        verdict = await run.result()
    return Result(verdict, run.parameters, [record async for record in run.trace()], run.fault)


async def _run_remotely(scenario: Scenario, executor: str, options: OptionFields) -> Result:
    from seoro.client import Client  # noqa: PLC0415 - Zenoh, for this option only

    async with Client() as client:
        run = await client.submit(executor, scenario, stop_if_lost=STOP_IF_LOST, **options)
        try:
            verdict = await run.result()
        except asyncio.CancelledError:
            with anyio.CancelScope(shield=True):
                await run.stop("the test was interrupted")
            raise
        records = [record async for record in run.records_so_far()]
    return Result(verdict, records[0]["parameters"] if records else {}, records, None)


# ---------------------------------------------------------------- reports of failures


def _failure(directives: Directives, result: Result, options: OptionFields, executor: str | None) -> str:
    verdict = result.verdict
    parts = [reason_text(verdict) or f"the scenario {verdict.status.value}"]
    if directives.expect != "passed":
        expected = directives.expect + (f", with {directives.reason!r} in the reason" if directives.reason else "")
        parts.append(f"expected: {expected}\nended: {verdict.status.value}")
    if result.fault is not None:
        parts.append(_traceback(result.fault))
    command = [*_command(result, options), *(["--on", executor] if executor is not None else [])]
    parts.append(f"run it alone: {shlex.join(command)}")
    return "\n\n".join(parts)


def _command(result: Result, options: OptionFields) -> list[str]:
    """Return the command line of `seoro exec` for the same run."""
    verdict, simulator = result.verdict, options.get("simulator")
    command = ["seoro", "exec", verdict.file, "--scenario", verdict.scenario, "--seed", str(verdict.seed)]
    if simulator is None:
        command += ["--clock", str(result.records[0]["clock"])]
    else:
        command += ["--sim", simulator.name] if simulator.name else ["--connect", str(simulator.endpoint)]
        command += ["--world", simulator.world] if simulator.world else []
        command += ["--rate", f"{simulator.rate:g}" if math.isfinite(simulator.rate) else "max"]
    for name, value in options.get("overrides", {}).items():
        command += ["--set", f"{name}={value}"]
    if file := options.get("parameters"):
        command += ["--params", str(file)]
    return command


def _traceback(fault: Exception) -> str:
    """Format the traceback of an action's exception without frames of seoro."""
    found = traceback.TracebackException.from_exception(fault)
    own = Path(seoro.__file__).parent
    frames = [frame for frame in found.stack if not Path(frame.filename).is_relative_to(own)]
    found.stack = traceback.StackSummary.from_list(frames)
    return "".join(found.format()).rstrip()


def _write_page(item: pytest.Item, result: Result) -> None:
    """Write the page of a run, if `--seoro-report` names a folder."""
    if item.config.getoption("seoro_report") is not None:
        from seoro.pytest_plugin.pages import write_page  # noqa: PLC0415 - for this option only

        write_page(item, result.records)


def _report(item: pytest.Item, result: Result, folder: Path) -> None:
    """Add the log to the report of a test, and keep the trace."""
    logs = [record for record in result.records if record["kind"] == "log"]
    lines = [f"{record['t']:9.3f} s  {record['level']:7}  {record['message']}" for record in logs[-MAX_LOGS:]]
    if len(logs) > MAX_LOGS:
        lines.insert(0, f"({len(logs) - MAX_LOGS} more before)")
    if lines:
        item.add_report_section("call", "scenario log", "\n".join(lines))
    trace = folder / "trace.jsonl"
    with trace.open("wb") as file:
        file.writelines(map(to_line, result.records))
    item.add_report_section("call", "scenario trace", str(trace))

"""Functions that run loaded scenarios: `start`, `replay`, `run`, `accept`."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import asynccontextmanager
from typing import TYPE_CHECKING, Any, Unpack

from seoro.embed.file_settings import with_file_settings
from seoro.embed.options import OptionFields, Options, options_from
from seoro.embed.preparation import prepare
from seoro.embed.runs import Run
from seoro.embed.scenarios import Scenario, to_scenario
from seoro.embed.world_settings import split_world
from seoro.errors import UsageError
from seoro.runtime.verdict import Verdict

if TYPE_CHECKING:
    from seoro.runtime.accept import Acceptance


@asynccontextmanager
async def start(scenario: Scenario, **options: Unpack[OptionFields]) -> AsyncIterator[Run]:
    """Start a run. When the block ends, the run is stopped and has cleaned up.

    Args:
        scenario: Result of `load`.
        options: The fields of `Options`, by name.

    Raises:
        InvalidScenario, UsageError: The scenario cannot be run with these options; nothing was started.
        BackendError: The simulator did not start.
    """
    async with start_with(scenario, options_from(options), "timeout=SECONDS") as run:
        yield run


@asynccontextmanager
async def start_with(scenario: Scenario, options: Options, timeout_option: str) -> AsyncIterator[Run]:
    """Start a run like `start`, for callers with another notation of options.

    Args:
        scenario: Result of `load`.
        options: The options.
        timeout_option: Option for the limit of wall time, for messages.

    Raises:
        InvalidScenario, UsageError, BackendError: As `start`.
    """
    settings, found = with_file_settings(to_scenario("scenario", scenario), options, timeout_option)
    async with prepare(scenario, settings) as run, run.running(found.limit):
        run.notes = tuple(found.notes)
        yield run


@asynccontextmanager
async def replay(
    scenario: Scenario, records: Sequence[Mapping[str, Any]], **options: Unpack[OptionFields]
) -> AsyncIterator[Run]:
    """Repeat a recorded run, with the events that its application emitted.

    On virtual and simulated clocks, the trace is the same again. Simulators, robots and output folders are not
    recorded; pass them as options.

    Args:
        scenario: Result of `load`.
        records: Trace of the earlier run.
        options: The fields of `Options`, by name; they take precedence over the trace.

    Raises:
        InvalidScenario, UsageError, BackendError: As `start`; `UsageError` also if the trace has no `run.start`.
    """
    recorded = recorded_options(records)
    recorded.update(options)
    async with start(scenario, **recorded) as run:
        yield run


def recorded_options(records: Sequence[Mapping[str, Any]]) -> OptionFields:
    """Return the options that repeat a recorded run, with the events that its application emitted.

    Args:
        records: Trace of the earlier run.

    Raises:
        UsageError: The trace has no `run.start`.
    """
    first = _run_start(records)
    return {
        "name": first["scenario"],
        "seed": first.get("seed"),
        "overrides": first["overrides"],
        "constraints": first["constraints"],
        "clock": first.get("clock"),
        "external": first.get("external", ()),
        "replay": records,
    }


def run(scenario: Scenario, **options: Unpack[OptionFields]) -> Verdict:
    """Run a scenario to its end in a new event loop, for scripts.

    Ctrl-C stops the run with a clean-up, then raises `KeyboardInterrupt`.

    Args:
        scenario: Result of `load`.
        options: The fields of `Options`, by name; `observers` receive the trace.

    Raises:
        InvalidScenario, UsageError, BackendError: As `start`; `UsageError` also if an event loop is running.
    """
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return asyncio.run(_run(scenario, options))
    raise UsageError(
        "`seoro.run` cannot be called from a running event loop",
        help="use `async with seoro.start(scenario) as run: verdict = await run.result()`",
    )


async def _run(scenario: Scenario, options: OptionFields) -> Verdict:
    async with start(scenario, **options) as started:
        return await started.result()


def accept(scenario: Scenario, records: Sequence[Mapping[str, Any]]) -> Acceptance:
    """Check whether a scenario accepts a trace (7.6), independently of the runtime.

    Args:
        scenario: Result of `load`.
        records: Records of the trace, from `Run.trace` or a file.

    Raises:
        InvalidScenario, UsageError: The scenario or the parameters of the trace are unknown in the file.
    """
    from seoro.runtime.accept import check_trace  # noqa: PLC0415 - slow to load, not needed for runs

    first = _run_start(records)
    overrides, _ = split_world(first["overrides"])
    plan = scenario.plan(first["scenario"], overrides, first["constraints"])
    return check_trace(plan, records)


def _run_start(records: Sequence[Mapping[str, Any]]) -> dict[str, Any]:
    """Return the `run.start` record of a trace.

    Raises:
        UsageError: The record is missing or invalid.
    """
    first: Mapping[str, Any] = next((each for each in records if each.get("kind") == "run.start"), {})
    name, overrides, constraints = (first.get(key) for key in ("scenario", "overrides", "constraints"))
    overrides, constraints = overrides or {}, constraints or []
    if not isinstance(name, str) or not isinstance(overrides, dict) or not isinstance(constraints, list):
        raise UsageError("invalid trace: expected `run.start` with `scenario` and `overrides`")
    texts = {str(path): str(value) for path, value in overrides.items()}
    return {**first, "overrides": texts, "constraints": [str(each) for each in constraints]}

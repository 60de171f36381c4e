"""Campaigns as tests: the mark `seoro_campaign`, for scenario files and for functions in Python."""

from __future__ import annotations

import inspect
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final, NoReturn

import pytest

from seoro.campaign.results.results import Results
from seoro.campaign.runs import End
from seoro.campaign.starting import run
from seoro.campaign.statistics.sequential_test import Decision
from seoro.campaign.stopping.rules import percent
from seoro.campaign.strategies.random import Uniform
from seoro.cli.terminal import error_text
from seoro.embed.options import OptionFields
from seoro.embed.scenarios import Scenario
from seoro.errors import BackendError, InvalidScenario, UsageError
from seoro.pytest_plugin import MARK

RUNS: Final = 1000
_REASONS: Final = 10
_EXAMPLE: Final = "# pytest: seoro_campaign(rate=0.95)"
_WORKERS: Final = "PYTEST_XDIST_WORKER_COUNT"


@dataclass(frozen=True)
class Wanted:
    """Arguments of the mark.

    Args:
        rate: Pass rate that is wanted with 95 % confidence, between 0 and 1.
        runs: Number of runs after which the test fails without a decision.
        vary: Constraints that make more parameters vary.
        jobs: Number of simultaneous runs; None for the processors, shared by the workers of pytest-xdist.
    """

    rate: float
    runs: int = RUNS
    vary: Sequence[str] = ()
    jobs: int | None = None


def run_file(mark: pytest.Mark, around: Path, options: OptionFields, folder: Path) -> None:
    """Run the campaign of a function in Python.

    Args:
        mark: Its mark, which names the scenario file.
        around: Folder of the test.
        options: Options of all runs.
        folder: Folder for the campaign.
    """
    if len(mark.args) != 1 or not isinstance(mark.args[0], str | os.PathLike):
        found = ", ".join(map(repr, mark.args)) or "none"
        _refuse(f"expected a scenario file, found {found}", '@pytest.mark.seoro_campaign("gaps.osc", rate=0.95)')
    _run(around / mark.args[0], mark, options, folder)


def run_scenario(mark: pytest.Mark, scenario: Scenario, options: OptionFields, folder: Path) -> None:
    """Run the campaign of a scenario that pytest has collected.

    Args:
        mark: Its mark.
        scenario: The scenario.
        options: Options of all runs.
        folder: Folder for the campaign.
    """
    if mark.args:
        _refuse(f"expected no file, found {mark.args[0]!r}", _EXAMPLE)
    _run(scenario, mark, options, folder)


def _run(scenario: Path | Scenario, mark: pytest.Mark, options: OptionFields, folder: Path) -> None:
    """Run a campaign, and fail the test unless its pass rate is high enough."""
    try:
        inspect.signature(Wanted).bind(**mark.kwargs)
    except TypeError as error:
        _refuse(str(error), _EXAMPLE)
    wanted, shared = Wanted(**mark.kwargs), OptionFields(**options)
    if shared.get("clock") is None and shared.get("simulator") is None:
        shared["clock"] = "virtual"
    try:
        results = run(
            scenario,
            strategy=Uniform(),
            runs=wanted.runs,
            until=[f"rate >= {wanted.rate!r}"],
            vary=wanted.vary,
            jobs=wanted.jobs or _jobs(),
            folder=folder / "campaign",
            **shared,
        )
    except (InvalidScenario, UsageError, BackendError) as error:
        pytest.fail(error_text(error), pytrace=False)
    decision = Decision.OPEN if results.stopped is None else results.stopped.decision
    if decision is not Decision.GOOD or not set(results.tally.ends) <= {End.PASSED, End.FAILED}:
        pytest.fail("\n".join(_failure(results, wanted, decision)), pytrace=False)


def _refuse(reason: str, example: str) -> NoReturn:
    pytest.fail(
        error_text(UsageError(f"invalid mark `{MARK}`: {reason}", help=f"for example `{example}`")), pytrace=False
    )


def _failure(results: Results, wanted: Wanted, decision: Decision) -> Sequence[str]:
    rate = results.rate()
    lines = [f"{rate}; expected at least {percent(wanted.rate)} with 95 % confidence"]
    if decision is Decision.OPEN:
        lines.append(f"{wanted.runs:,} runs do not decide this; expect a lower rate, or allow more `runs`")
    lines += [f"{results.campaign.manifest.shown}: {results.tally.text}", "", *_reasons(results)]
    return [*lines, "", f"report: {results.write()[0]}"]


def _reasons(results: Results) -> Sequence[str]:
    """Return the reasons of runs that did not pass, with a command for the first of each."""
    counts: dict[str, tuple[int, int]] = {}
    for row in results.rows():
        if row.status is not End.PASSED:
            key = f"{row.reason_key or row.status.value}{f' at {row.where}' if row.where else ''}"
            count, first = counts.get(key, (0, row.run))
            counts[key] = count + 1, first
    lines = []
    for reason, (count, first) in sorted(counts.items(), key=lambda item: -item[1][0])[:_REASONS]:
        lines.append(f"{count:6,}  {reason}")
        lines.append(f"        seoro campaign replay {results.folder} {first}")
    return lines


def _jobs() -> int:
    """Return the number of processors for each worker of pytest-xdist, at least one."""
    return max(1, len(os.sched_getaffinity(0)) // int(os.environ.get(_WORKERS, "1")))

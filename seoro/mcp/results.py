"""Tools that read results: runs, why they failed, and comparisons of runs and campaigns."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from pathlib import Path
from threading import Lock
from typing import Any, Final

from pydantic import Field

from seoro.campaign.comparison.comparing import MARGIN, compare
from seoro.campaign.comparison.data import comparison_data
from seoro.errors import UsageError
from seoro.files.inputs import Kind, open_input
from seoro.mcp.bounds import MOST_ITEMS, Bounds
from seoro.mcp.served_folder import ServedFolder
from seoro.mcp.tool import Answer, Arguments
from seoro.report.folder import measurements_of
from seoro.runtime.execution.outputs import TRACE
from seoro.traces.comparison import NoBeginning, compare_runs
from seoro.traces.explanation_text import explanation_lines
from seoro.traces.reader import InvalidRecord, Record, read_trace, valid_records
from seoro.traces.summary import Summary, summarise
from seoro.ui.local_runs import LocalRuns

_LOGS: Final = 20  # latest lines of the log


class ListRuns(Arguments):
    """Arguments of `list_runs`."""

    offset: int = Field(0, ge=0, description="number of runs to skip, from the latest on")


class RunEntry(Answer):
    """A run in the list."""

    run: str = Field(description="its output folder, for `explain_run` and `compare_runs`")
    scenario: str
    status: str
    reason: str
    started: float | None = Field(description="wall time [s since 1970]")


class Runs(Answer):
    """Runs below the folder, the latest first."""

    runs: list[RunEntry]
    total: int
    next_offset: int | None = Field(description="offset of the rest; null at the end")


class ExplainRun(Arguments):
    """Arguments of `explain_run`."""

    run: str = Field(description="output folder of the run, or its trace, relative to the served folder")


class RunResult(Answer):
    """Result of a run."""

    run: str
    scenario: str
    status: str = Field(description="passed, failed, error or cancelled; unfinished without an end")
    reason: str
    source: str = Field(description="place in the scenario that decided the verdict; may be empty")
    explanation: list[str] = Field(description="what the scenario did and waited for at the verdict, with values")
    seed: int | None
    parameters: dict[str, Any]
    duration: float = Field(description="time on the clock of the run [s]")
    failed: list[dict[str, Any]] = Field(description="failed behaviors with their reasons")
    unfinished: list[dict[str, Any]]
    variables: dict[str, Any] = Field(description="last values")
    measurements: dict[str, Any] = Field(description="measurements of the simulator, in SI units")
    logs: list[str] = Field(description="last lines of the log")
    cut: list[str] = Field(description="places of values that were cut")


class CompareRuns(Arguments):
    """Arguments of `compare_runs`."""

    first: str = Field(description="output folder of a run, or its trace, relative to the served folder")
    second: str = Field(description="the same of another run")


class RunComparison(Answer):
    """Comparison of two runs."""

    is_equal: bool
    settings: list[list[str]] = Field(description="name and both values of each setting that differs")
    difference: dict[str, Any] | None = Field(description="first difference of the records; null if equal")
    cut: list[str] = Field(description="places of values that were cut")


class CompareCampaigns(Arguments):
    """Arguments of `compare_campaigns`."""

    before: str = Field(description="folder of the first campaign, relative to the served folder")
    after: str = Field(description="folder of the second one")
    margin: float = Field(MARGIN, gt=0.0, lt=1.0, description="largest drop of the pass rate that is not worse")


class CampaignComparison(Answer):
    """Comparison of two campaigns."""

    outcome: str = Field(description="worse, not worse or undecided")
    comparison: dict[str, Any] = Field(description="as by `seoro campaign compare --json`")
    cut: list[str] = Field(description="places of values that were cut")


class ResultReader:
    """Reads results.

    Args:
        served: Folder of the server.
    """

    def __init__(self, served: ServedFolder) -> None:
        self._served = served
        self._runs = LocalRuns((served.root,))
        self._lock = Lock()  # of the runs

    def list_runs(self, given: ListRuns) -> Runs:
        """List runs."""
        with self._lock:
            known = self._runs.find()
        found = [
            (each.run, name)
            for each in known
            if (name := self._served.name(Path(each.run.folder))) is not None
            and self._served.name(Path(each.run.folder) / TRACE) is not None  # may be a link
        ]
        found.sort(key=lambda pair: (-(pair[0].started or 0.0), pair[1]))
        bounds, shown = Bounds(), found[given.offset : given.offset + MOST_ITEMS]
        after = given.offset + len(shown)
        return Runs(
            runs=[
                RunEntry(
                    run=name,
                    scenario=run.scenario,
                    status=str(run.status),
                    reason=bounds.apply(run.reason, "reason"),
                    started=run.started,
                )
                for run, name in shown
            ],
            total=len(found),
            next_offset=after if after < len(found) else None,
        )

    def explain_run(self, given: ExplainRun) -> RunResult:
        """Explain a run."""
        trace = self._served.trace(given.run)
        logs: deque[Record] = deque(maxlen=_LOGS)
        problems: list[InvalidRecord] = []
        with open_input(trace, Kind.TRACE) as file:
            summary = summarise(_noting(logs, valid_records(read_trace(file), problems)), problems)
        if summary.run is None:
            raise UsageError(f"the trace of `{given.run}` has no beginning", help="name the folder of a whole run")
        return _result(given.run, summary, self._measurements(trace.parent), logs)

    def compare_runs(self, given: CompareRuns) -> RunComparison:
        """Compare two runs."""
        names = (given.first, given.second)
        first, second = map(self._served.trace, names)
        with open_input(first, Kind.TRACE) as one, open_input(second, Kind.TRACE) as other:
            try:
                found = compare_runs(*(valid_records(read_trace(file), []) for file in (one, other)))
            except NoBeginning as error:
                raise UsageError(
                    f"the trace of `{names[error.index]}` has no beginning", help="compare whole runs"
                ) from error
        bounds = Bounds()
        data = bounds.apply(found.data, "comparison")
        return RunComparison(
            is_equal=found.is_equal, settings=data["settings"], difference=data["difference"], cut=bounds.cut
        )

    def compare_campaigns(self, given: CompareCampaigns) -> CampaignComparison:
        """Compare two campaigns."""
        before, after = map(self._campaign, (given.before, given.after))
        found = compare(before, after, margin=given.margin)
        bounds = Bounds()
        data = bounds.apply(comparison_data(found), "comparison")
        data["before"]["folder"], data["after"]["folder"] = given.before, given.after
        return CampaignComparison(outcome=found.outcome.value, comparison=data, cut=bounds.cut)

    def _campaign(self, name: str) -> Path:
        """Return the folder of a campaign, whose files are in the served folder."""
        folder = self._served.folder(name)
        for path in folder.rglob("*"):
            if path.is_symlink() and self._served.name(path) is None:
                raise UsageError(f"a link in `{name}` leads out of the served folder", help="remove the link")
        return folder

    def _measurements(self, folder: Path) -> dict[str, Any]:
        """Read the measurements beside a trace, unless a link leads out of the folder."""
        is_inside = self._served.name(folder / "measurements.json") is not None
        return measurements_of(folder) if is_inside else {}


def _noting(logs: deque[Record], records: Iterator[Record]) -> Iterator[Record]:
    """Yield records, and note those of the log."""
    for record in records:
        if record["kind"] == "log":
            logs.append(record)
        yield record


def _result(name: str, summary: Summary, measurements: dict[str, Any], logs: deque[Record]) -> RunResult:
    data, run, bounds = summary.plain(), summary.run or {}, Bounds()
    seed = run.get("seed")
    return RunResult(
        run=name,
        scenario=str(run.get("scenario", "")),
        status=str(data["status"] or "unfinished"),
        reason=bounds.apply(str(data["reason"] or ""), "reason"),
        source=str(data["source"] or ""),
        explanation=bounds.apply(list(explanation_lines(data["explanation"])), "explanation"),
        seed=seed if isinstance(seed, int) else None,
        parameters=bounds.apply(_object(run.get("parameters")), "parameters"),
        duration=data["duration"],
        failed=bounds.apply(data["failed"], "failed"),
        unfinished=bounds.apply(data["unfinished"], "unfinished"),
        variables=bounds.apply(data["variables"], "variables"),
        measurements=bounds.apply(measurements, "measurements"),
        logs=bounds.apply([f"{each['t']:.3f} s {each.get('message', '')}" for each in logs], "logs"),
        cut=bounds.cut,
    )


def _object(value: object) -> dict[str, Any]:
    return value if isinstance(value, dict) else {}

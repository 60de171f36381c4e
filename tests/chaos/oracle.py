"""Oracle of rounds: finds violations in the observations after a round, without side effects."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from tests.chaos.plan import Submission

VERDICTS = ("passed", "failed")
ENDED = ("passed", "failed", "error", "cancelled")  # final states of runs whose trace has an end


@dataclass(frozen=True)
class Received:
    """Reports that a client received.

    Args:
        submission: Its submission.
        run: Id of the run that was acknowledged; empty if none was.
        verdict: Reported verdict; empty without one.
        invalid: Reason why its submission or run is invalid; empty if it is valid.
        reason: The reason of the verdict, or the error.
    """

    submission: Submission
    run: str = ""
    verdict: str = ""
    invalid: str = ""
    reason: str = ""


@dataclass(frozen=True)
class FoundRun:
    """A run that an executor has kept.

    Args:
        run: Its id.
        executor: The executor.
        file: Name of its scenario file, which is another for each submission.
        state: Its state.
        reason: The reason of its state.
        records: Its trace.
    """

    run: str
    executor: str
    file: str
    state: str
    reason: str = ""
    records: Sequence[Mapping[str, Any]] = ()


@dataclass(frozen=True)
class Found:
    """Everything that was found after a round, when all parts had time to recover.

    Args:
        received: Reports that clients received.
        runs: Runs of the round on all executors.
        held: Held robots, with their holders.
        left: Processes and files that are left and belong to no part.
        unreachable: Parts that do not answer although they run and are reached.
    """

    received: Sequence[Received] = ()
    runs: Sequence[FoundRun] = ()
    held: Mapping[str, str] = field(default_factory=dict)
    left: Sequence[str] = ()
    unreachable: Sequence[str] = ()


def violations(found: Found) -> list[str]:
    """Find the violations of what seoro promises; empty if all holds."""
    return [
        *_lost_or_doubled(found),
        *_wrong_verdicts(found),
        *_torn_traces(found),
        *_held_twice(found),
        *(f"{robot} is still held: {holder}" for robot, holder in found.held.items()),
        *(f"left behind: {each}" for each in found.left),
        *(f"{each} does not answer" for each in found.unreachable),
    ]


def _lost_or_doubled(found: Found) -> Iterator[str]:
    by_id = Counter(run.run for run in found.runs)
    yield from (f"run {run} is there {count} times" for run, count in by_id.items() if count > 1)
    by_file = Counter(run.file for run in found.runs)
    yield from (f"{file} was run {count} times" for file, count in by_file.items() if count > 1)
    for received in found.received:
        if received.run and received.run not in by_id:
            yield f"run {received.run} was acknowledged, and is lost"
    for run in found.runs:
        if run.state in ("queued", "running"):
            yield f"run {run.run} has no end: {run.state} ({run.reason})"


def _wrong_verdicts(found: Found) -> Iterator[str]:
    expected = {_file(received.submission): received.submission.expected for received in found.received}
    for run in found.runs:
        if run.state in VERDICTS and run.state != expected.get(run.file, run.state):
            yield f"run {run.run} ({run.file}) {run.state}, and the scenario is right: {run.reason}"
        if run.state == "invalid":
            yield f"run {run.run} ({run.file}) is invalid, and the scenario is not: {run.reason}"
    states = {run.run: run.state for run in found.runs}
    for received in found.received:
        if received.verdict in VERDICTS and received.verdict != received.submission.expected:
            yield f"a client received `{received.verdict}` for {_file(received.submission)}: {received.reason}"
        if received.verdict and states.get(received.run, received.verdict) != received.verdict:
            yield f"a client received `{received.verdict}` for run {received.run}, which is {states[received.run]}"
        if received.invalid and received.run:
            yield f"a client received {_file(received.submission)} as invalid: {received.invalid}"


def _torn_traces(found: Found) -> Iterator[str]:
    for run in found.runs:
        if [record.get("seq") for record in run.records] != list(range(len(run.records))):
            yield f"the trace of run {run.run} has gaps or doubles"
        kinds = Counter(record.get("kind") for record in run.records)
        if kinds["run.start"] > 1 or kinds["run.end"] > 1:
            yield f"the trace of run {run.run} begins or ends more than once"
        if run.records and run.state in VERDICTS and run.records[-1].get("kind") != "run.end":
            yield f"the trace of run {run.run}, which {run.state}, has no end"


def _held_twice(found: Found) -> Iterator[str]:
    """Runs that passed have driven; no two of them drove one robot at the same time."""
    drives: dict[str, list[tuple[str, str, str]]] = {}
    robots = {_file(received.submission): received.submission.robot for received in found.received}
    for run in found.runs:
        robot = robots.get(run.file, "")
        if robot and run.state == "passed" and run.records:
            drives.setdefault(robot, []).append(
                (str(run.records[0]["wall"]), str(run.records[-1]["wall"]), run.run)
            )
    for robot, spans in drives.items():
        spans.sort()
        for (_, end, first), (start, _, second) in pairwise(spans):
            if start < end:
                yield f"{robot} was driven by the runs {first} and {second} at the same time"


def _file(submission: Submission) -> str:
    return f"client_{submission.number}.osc"

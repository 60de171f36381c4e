"""Workers of campaigns that give way to waiting runs."""

from __future__ import annotations

import time

import pytest

from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import RunInfo, State
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.runs.active_run import ActiveRun
from seoro.executor.runs.given_runs import MOST_PENDING, GivenRuns
from seoro.executor.runs.shifts import SHIFT, ask_to_give_way
from seoro.executor.runs.tail import Pace

RUN = "0" * 32


def run_of(by: str, since: float = 0.0, campaign: str = "") -> ActiveRun:
    """Return a run of a client that began some time ago [s], or a worker of a campaign."""
    options = wire.BundledOptions(overrides={}, grace=5.0)
    file = wire.BundleFile(path="a.osc", hash="0" * 64, size=0)
    manifest = wire.Manifest(files=(file,), entry="a.osc", shown="a.osc", options=options)
    worker = wire.CampaignWorker(name="w", digest=campaign * 64, version="1") if campaign else None
    started = time.time() - since
    info = RunInfo(run=RUN, file="a.osc", by=by, state=State.RUNNING, submitted=started, started=started)
    return ActiveRun(info, wire.Submission(run=RUN, manifest=manifest, by=by, campaign=worker), Pace())


def wanted(*active: ActiveRun) -> list[bool]:
    return [live.info.is_wanted for live in active]


def test_the_oldest_worker_gives_way_to_each_waiting_run() -> None:
    old, older, new, single = (
        run_of("anna", SHIFT + 1.0, "a"),
        run_of("anna", SHIFT + 9.0, "a"),
        run_of("anna", SHIFT - 5.0, "a"),
        run_of("bert", SHIFT + 99.0),
    )
    active = (old, older, new, single)
    ask_to_give_way(active, [run_of("bert")])
    assert wanted(*active) == [False, True, False, False]
    ask_to_give_way(active, [run_of("bert")])
    assert wanted(*active) == [False, True, False, False], "it was asked already"
    ask_to_give_way(active, [run_of("bert"), run_of("anna"), run_of("anna")])
    assert wanted(*active) == [True, True, False, False], "the new one has just begun"


def test_workers_of_one_campaign_do_not_replace_each_other() -> None:
    worker = run_of("anna", SHIFT + 1.0, "a")
    ask_to_give_way([worker], [run_of("anna", campaign="a")])
    assert wanted(worker) == [False]
    ask_to_give_way([worker], [run_of("anna", campaign="b")])
    assert wanted(worker) == [True]


def given(part: int, size: int = 1) -> wire.PlannedRuns:
    run = wire.PlannedRun(number=1, variant=1, repeat=1, seed=1, values={"a": "x" * 900}, strategy="grid")
    return wire.PlannedRuns(run=RUN, part=part, runs=(run,) * size)


def test_a_repeated_part_is_passed_on_once_and_unread_parts_are_bounded() -> None:
    runs, sent = GivenRuns(), list[bytes]()
    runs.give(given(1, 20), sent.append)
    runs.give(given(1, 20), sent.append)
    assert len(sent) == 1
    with pytest.raises(RequestRefused, match="has not read earlier runs"):
        runs.give(given(2, 20), sent.append)
    runs.note_read(1)
    runs.give(given(2, 20), sent.append)
    assert len(sent) == 2 and sum(map(len, sent)) > MOST_PENDING


def test_runs_are_given_to_active_workers_only() -> None:
    for live in (run_of("anna"), run_of("anna", campaign="a")):
        with pytest.raises(RequestRefused, match="is not an active worker"):
            live.give_runs(given(1))

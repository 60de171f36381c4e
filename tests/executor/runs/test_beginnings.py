"""Lists of runs have the names of scenarios and robots, from the beginnings of traces."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges.executor.messages import RunInfo, State
from seoro.executor.runs import beginnings
from seoro.executor.runs.beginnings import Beginnings
from seoro.executor.storage.run_folder import RunFolder
from tests.report.traces import records, write


def info(run: str, state: State = State.RUNNING, started: float | None = 1.0) -> RunInfo:
    return RunInfo(run=run, file="x.osc", by="", state=state, submitted=1.0, started=started)


def named(tmp_path: Path) -> Beginnings:
    return Beginnings(lambda run: RunFolder(tmp_path / run))


def test_the_names_come_when_the_trace_has_them(tmp_path: Path) -> None:
    run, known = "0" * 32, named(tmp_path)
    assert known.add_to([info(run, State.QUEUED, None)])[0].robots == ()
    found = records()
    write(tmp_path / run, found[:1])
    [listed] = known.add_to([info(run)])
    assert (listed.scenario, listed.robots) == (found[0]["scenario"], ())
    trace = write(tmp_path / run, found)
    [listed] = known.add_to([info(run)])
    assert (listed.scenario, listed.robots) == (found[0]["scenario"], ("tb4",))
    trace.unlink()  # it is not read again
    assert known.add_to([info(run)]) == (listed,)


def test_names_and_their_number_are_bounded(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(beginnings, "MOST_READ", 2)
    monkeypatch.setattr(beginnings, "MOST_KNOWN", 3)
    entities = [{"name": f"\udc80{number}" + "x" * 1000, "kind": "robot"} for number in range(100)]
    scene = {"t": 0.0, "kind": "scene", "entities": entities}
    known, runs = named(tmp_path), [info(f"{number:032x}", State.PASSED) for number in range(4)]
    for each in runs:
        write(tmp_path / each.run, [{**records()[0], "scenario": "s" * 1000}, scene])
    read = [[len(each.robots) for each in known.add_to(runs)] for _ in range(2)]
    assert read == [[20, 20, 0, 0], [0, 20, 20, 20]]
    [listed] = known.add_to(runs[3:])
    assert (listed.scenario, listed.robots[0]) == ("s" * 100, "?0" + "x" * 98)

"""Causes of records, and their chain in sentences."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from seoro.cli.main import main
from seoro.embed.options import Options
from seoro.traces.causes import CauseIndex, steps
from tests.runtime.conftest import Prepare, prepare_text

__all__ = ["prepare_text"]

Trace = list[dict[str, Any]]

SCENARIO = """
scenario inner:
    event ping
    event pong
    on @ping:
        emit pong
    do serial:
        wait elapsed(1s)
        emit ping
        wait elapsed(0.5s)

scenario main:
    event go
    event stopped is rise(x > 1)
    var x: int = 0
    do serial:
        parallel:
            a: inner()
            serial:
                wait @a.ping
                increment(x)
                increment(x)
            wait @stopped
        one_of:
            wait elapsed(3s)
            serial:
                wait elapsed(1s)
                emit go
        limited: serial:
            wait elapsed(9s)
        with:
            until elapsed(2s)
        parallel:
            doomed: wait elapsed(5s)
            serial:
                wait elapsed(1s)
                compare(x, "==", 7)
"""


@pytest.fixture
async def trace(prepare_text: Prepare) -> Trace:
    async with prepare_text(SCENARIO, Options(seed=0, clock="virtual")) as run, run.running():
        return [json.loads(json.dumps(record)) async for record in run.trace()]


def find(trace: Trace, kind: str, name: str, number: int = 0) -> dict[str, Any]:
    """Return a record of a behavior, an event or a variable; ends have the name of the behavior."""
    names: Mapping[int, str] = {r["id"]: r["name"] for r in trace if r["kind"] == "behavior.start"}
    found = [
        record
        for record in trace
        if record["kind"] == kind
        and (record.get("name") or record.get("path") or names.get(record.get("id", -1))) == name
    ]
    return found[number]


def why(trace: Trace, record: Mapping[str, Any]) -> list[str]:
    """Return the sentences of a chain of causes, without places."""
    found = steps(trace, CauseIndex(trace).chain(record["seq"]))
    return [step.text.replace(f" ({step.record.get('source')})", "") for step in found]


def test_every_start_end_and_event_has_an_earlier_cause(trace: Trace) -> None:
    kinds = ("behavior.start", "behavior.end", "event", "variable", "run.end")
    assert all(0 <= record["cause"] < record["seq"] for record in trace if record["kind"] in kinds)


def test_a_wait_ends_by_the_event_that_it_received(trace: Trace) -> None:
    end = find(trace, "behavior.end", "wait", 1)
    assert trace[end["cause"]]["name"].endswith("a[0].ping")
    assert trace[trace[end["cause"]]["cause"]]["type"] == "emit"


def test_a_wait_for_time_ends_by_its_own_start(trace: Trace) -> None:
    end = find(trace, "behavior.end", "wait")
    assert trace[end["cause"]]["id"] == end["id"]


def test_a_reaction_starts_by_its_event(trace: Trace) -> None:
    pong = next(record for record in trace if record["kind"] == "event" and record["name"].endswith("pong"))
    reaction = trace[pong["cause"]]
    assert trace[reaction["cause"]]["name"].endswith("ping")


def test_a_derived_event_occurs_by_the_change_of_a_variable(trace: Trace) -> None:
    stopped = find(trace, "event", "main.stopped")
    change = trace[stopped["cause"]]
    assert (change["path"], change["value"]) == ("x", 2)
    assert trace[change["cause"]]["name"] == "increment"


def test_members_start_by_the_ends_of_their_predecessors(trace: Trace) -> None:
    start = find(trace, "behavior.start", "one_of")
    assert trace[start["cause"]]["id"] == find(trace, "behavior.start", "parallel")["id"]
    assert trace[start["cause"]]["kind"] == "behavior.end"


def test_a_composition_ends_by_its_last_member(trace: Trace) -> None:
    assert (
        trace[find(trace, "behavior.end", "parallel")["cause"]]["id"] == find(trace, "behavior.start", "a")["id"]
    )


def test_a_failure_is_the_cause_of_the_cancellation_of_others(trace: Trace) -> None:
    doomed, failed = find(trace, "behavior.end", "doomed"), find(trace, "behavior.end", "compare")
    assert (doomed["status"], failed["status"]) == ("cancelled", "failed")
    serial = next(r for r in trace if r["kind"] == "behavior.end" and r["cause"] == failed["seq"])
    assert doomed["cause"] == serial["seq"]


def test_the_end_of_a_run_is_followed_to_its_start(trace: Trace) -> None:
    chain = why(trace, trace[-1])
    assert chain[0].startswith("the run ended: failed: ")
    assert chain[-1] == "the run of `main` started"
    assert any("`wait elapsed(1s)`" in each and "succeeded by itself, 1.000 s after" in each for each in chain)
    assert any(each.endswith("was cancelled") and "`wait elapsed(9s)`" in each for each in chain)


async def test_behaviors_have_their_text_and_their_node(trace: Trace) -> None:
    start = trace[0]
    nodes = {node["id"]: node for node in start["tree"]}
    assert start["format"] == "1.1"
    assert {node["scenario"] for node in nodes.values()} == {"main", "inner"}
    invoked = find(trace, "behavior.start", "a")
    assert nodes[invoked["node"]]["invokes"] == "inner"
    for record in trace:
        if record["kind"] == "behavior.start" and record["name"] != "main" and record["type"] != "modifier":
            node = nodes[record["node"]]
            assert (node["type"], node["source"]) == (record["type"], record["source"])
            assert node["source_end"] == record["source_end"]
    entry = next(source for source in start["sources"] if "text" in source)
    line, column = (int(part) for part in invoked["source"].rsplit(":", 2)[1:])
    assert entry["text"].splitlines()[line - 1][column - 1 :] == "inner()"
    assert all(source["library"] for source in start["sources"] if "text" not in source)


def _write(path: Path, records: Trace) -> str:
    path.write_text("".join(json.dumps(record) + "\n" for record in records))
    return str(path)


def test_why_prints_the_chain(trace: Trace, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = _write(tmp_path / "trace.jsonl", trace)
    assert main(["trace", file, "--why", "end"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].endswith(f"#{len(trace) - 1}")
    assert lines[-1].endswith("the run of `main` started  #0")
    assert main(["trace", file, "--why", "1", "--json"]) == 0
    assert [json.loads(line)["seq"] for line in capsys.readouterr().out.splitlines()] == [1, 0]


@pytest.mark.parametrize(
    ("wanted", "edit", "message"),
    [
        ("9999", lambda trace: trace, "no record 9999; the trace has the records 0 to"),
        ("end", lambda trace: trace[:-1], "the trace has no end of the run"),
        ("3", lambda trace: trace[1:], "records are missing from the trace"),
        ("3", lambda trace: [{**r, "cause": None} for r in trace], "the trace has no causes"),
    ],
)
def test_records_without_a_chain_are_refused(
    trace: Trace, tmp_path: Path, capsys: pytest.CaptureFixture[str], wanted: str, edit: Any, message: str
) -> None:
    assert main(["trace", _write(tmp_path / "trace.jsonl", edit(trace)), f"--why={wanted}"]) == 2
    assert message in capsys.readouterr().err

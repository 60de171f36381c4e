"""The timeline and the summary of a trace."""

import json
from typing import Any

from seoro.traces.reader import Filter, read_trace, select
from seoro.traces.summary import summarise
from seoro.traces.summary_text import summary_lines
from seoro.traces.timeline import timeline
from tests.traces.conftest import as_file

Trace = list[dict[str, Any]]


def lines(records: Trace) -> list[str]:
    return [str(line) for line in timeline(records)]


def test_records_are_indented_by_their_surrounding_behaviors(trace: Trace) -> None:
    shown = lines(trace)
    assert shown[1].startswith("     0.000  > scenario main  ")
    [log] = [line for line in shown if '" gone' in line]
    [around] = [line for line in shown if "> log" in line]
    assert log.index('"') == around.index(">") + 2


def test_behaviors_that_end_at_once_have_one_line(trace: Trace) -> None:
    increments = [line for line in lines(trace) if "increment" in line]
    assert len(increments) == 1
    assert increments[0].split()[1] == "+"


def test_ends_say_how_long_and_why(trace: Trace) -> None:
    shown = lines(trace)
    assert any("- nap  cancelled, after 5.000 s" in line.replace("serial ", "") for line in shown)
    assert any(
        "x modifier timeout  failed, after 5.000 s, timeout: still running after 5 s" in line for line in shown
    )


def test_the_verdict_is_explained(trace: Trace) -> None:
    last = lines(trace)[-1]
    assert "timeout: still running after 5 s" in last
    assert "waiting since 0.000 s: `wait elapsed(10s)`" in last
    assert "waiting since 0.000 s: `wait elapsed(10s)`" in "\n".join(summary_lines(summarise(trace, [])))


def test_an_end_without_its_start_is_shown(trace: Trace) -> None:
    later = list(select(trace, Filter(start=5.0)))
    assert any("- behavior " in line for line in lines(later))


def test_kinds_that_are_new_are_shown_when_asked_for() -> None:
    records: Trace = [{"t": 1.0, "kind": "weather", "sun": True}]
    assert lines(records) == []
    assert [str(line) for line in timeline(records, is_whole=True)] == ['     1.000  ? weather  {"sun": true}']


def test_records_are_chosen_by_kind_time_path_and_text(trace: Trace) -> None:
    def kinds(choice: Filter) -> list[str]:
        return [record["kind"] for record in select(trace, choice)]

    assert kinds(Filter()) == [record["kind"] for record in trace]
    assert kinds(Filter(kinds=["log", "run.*"])) == ["run.start", "log", "run.end"]
    assert kinds(Filter(paths=["main/parallel[0]/nap[2]"])) == ["behavior.start", "behavior.end"]
    assert kinds(Filter(paths=["main.go"])) == ["event"]
    assert set(kinds(Filter(paths=["*/nap*"]))) == {"behavior.start", "behavior.end"}
    assert kinds(Filter(kinds=["event"], start=0.5, end=1.0, paths=["*.go"])) == ["event"]


def test_the_summary_adds_up(trace: Trace) -> None:
    summary = summarise(trace, [])
    plain = json.loads(json.dumps(summary.plain()))
    assert (plain["status"], plain["duration"]) == ("failed", 5.0)
    assert sum(plain["records"].values()) == len(trace)
    [waits] = [place for place in plain["behaviors"] if place["type"] == "wait" and place["count"] == 3]
    assert (waits["total"], waits["longest"], waits["succeeded"]) == (3.0, 1.0, 3)
    assert plain["slowest"][0]["duration"] == 5.0
    assert [ended["name"] for ended in plain["cancelled"]][:2] == ["wait", "nap"]
    assert plain["failed"][0]["reason"] == "timeout: still running after 5 s"
    assert plain["variables"] == {"count": 1}
    assert plain["events"]["main.go"] == 1
    assert plain["coverage"] == {"level": {"1": 3}}
    assert plain["unfinished"] == []
    text = "\n".join(summary_lines(summary))
    assert text.startswith("failed  main in 5.000 s")
    assert "3 x wait" in text


def test_a_run_that_was_killed_has_behaviors_that_did_not_end(trace: Trace) -> None:
    file = as_file(trace[:12])
    summary = summarise([record for record in read_trace(file) if isinstance(record, dict)], [])
    assert summary.end is None
    assert summary.unfinished[0].name == "main"
    assert next(summary_lines(summary)).startswith("unfinished  main")

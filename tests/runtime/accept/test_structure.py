"""Traces that are no traces, whatever the scenario says."""

import pytest

from seoro.errors import InvalidUse
from seoro.lang.frontend import lower
from seoro.runtime.accept import check_trace
from tests.runtime.accept.conftest import Traced, TraceText

TEXT = """
scenario main:
    do serial:
        wait elapsed(1s)
        parallel:
            log("a")
            wait elapsed(2s)
"""


@pytest.fixture
async def traced(trace_text: TraceText) -> Traced:
    found = await trace_text(TEXT)
    assert found.accept().accepted
    return found


def test_a_gap_in_the_numbers(traced: Traced) -> None:
    for record in traced.records[5:]:
        record["seq"] += 1
    assert "has the number 6 where 5 is due" in traced.messages
    assert traced.accept().violations[0].records == (6,)


def test_time_that_goes_back(traced: Traced) -> None:
    traced.end("parallel")["t"] = 0.5
    assert "time goes back" in traced.messages


def test_an_end_that_is_missing(traced: Traced) -> None:
    traced.drop(traced.end("log"))
    assert "has no end" in traced.messages


def test_an_end_that_comes_twice(traced: Traced) -> None:
    end = traced.end("log")
    traced.insert(end, **{**end, "wall": ""})
    assert "ends and does not run" in traced.messages


def test_a_start_that_is_missing(traced: Traced) -> None:
    traced.drop(traced.start("log"))
    assert "structure" in traced.broken


def test_a_member_that_ends_after_what_is_around_it(traced: Traced) -> None:
    traced.move(traced.end("log"), after=traced.end("parallel"))
    assert "ends before" in traced.messages


def test_a_trace_without_its_start_or_end(traced: Traced) -> None:
    without_start, without_end = traced.copy(), traced.copy()
    without_start.drop(without_start.find("run.start"))
    with pytest.raises(InvalidUse, match="does not say what was run"):
        without_start.accept()
    plan = lower(traced.scenario.checked, "main", {})
    assert "there is no `run.start`" in [v.message for v in check_trace(plan, without_start.records).violations]
    without_end.drop(without_end.find("run.end"))
    assert "there is no `run.end`" in without_end.messages


def test_a_record_after_the_end(traced: Traced) -> None:
    traced.insert(traced.find("run.end"), kind="log", message="late", level="info", source="")
    assert "there is a record after `run.end`" in traced.messages


def test_fields_that_are_missing_or_of_another_type(traced: Traced) -> None:
    del traced.start("log")["parent"]
    traced.find("run.end")["duration"] = "long"
    assert "`behavior.start` needs `parent`" in traced.messages
    assert "`run.end` needs `duration`" in traced.messages


def test_a_duration_that_is_not_that_of_the_run(traced: Traced) -> None:
    traced.find("run.end")["duration"] = 7.0
    assert traced.broken == {"structure"}


def test_anything_else_than_records(traced: Traced) -> None:
    traced.records[3] = {"kind": 3}
    assert "a record needs `seq`, `t` and `kind`" in traced.messages

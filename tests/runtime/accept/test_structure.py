"""Traces that are invalid for any scenario."""

import pytest

from seoro.errors import UsageError
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


def test_a_gap_in_the_numbers_is_rejected(traced: Traced) -> None:
    for record in traced.records[5:]:
        record["seq"] += 1
    assert "has the number 6; expected 5" in traced.messages
    assert traced.accept().violations[0].records == (6,)


@pytest.mark.parametrize("cause", [-1, 3, 1_000, "0", 0.5])
def test_a_cause_that_is_not_an_earlier_record_is_rejected(traced: Traced, cause: object) -> None:
    traced.records[3]["cause"] = cause
    assert f"the cause of a record must be an earlier one, found {cause!r}" in traced.messages


def test_time_that_goes_back_is_rejected(traced: Traced) -> None:
    traced.end("parallel")["t"] = 0.5
    assert "time goes back" in traced.messages


def test_a_missing_end_is_rejected(traced: Traced) -> None:
    traced.drop(traced.end("log"))
    assert "has no end" in traced.messages


def test_a_repeated_end_is_rejected(traced: Traced) -> None:
    end = traced.end("log")
    traced.insert(end, **{**end, "wall": ""})
    assert "ends, but is not running" in traced.messages


def test_a_missing_start_is_rejected(traced: Traced) -> None:
    traced.drop(traced.start("log"))
    assert "structure" in traced.broken


def test_a_member_that_ends_after_its_composition_is_rejected(traced: Traced) -> None:
    traced.move(traced.end("log"), after=traced.end("parallel"))
    assert "ends before" in traced.messages


def test_a_trace_without_its_start_or_end_is_rejected(traced: Traced) -> None:
    without_start, without_end = traced.copy(), traced.copy()
    without_start.drop(without_start.find("run.start"))
    with pytest.raises(UsageError, match=r"expected `run\.start` with"):
        without_start.accept()
    plan = lower(traced.scenario.checked, "main", {})
    assert "missing `run.start`" in [v.message for v in check_trace(plan, without_start.records).violations]
    without_end.drop(without_end.find("run.end"))
    assert "missing `run.end`" in without_end.messages


def test_a_record_after_the_end_is_rejected(traced: Traced) -> None:
    traced.insert(traced.find("run.end"), kind="log", message="late", level="info", source="")
    assert "a record follows `run.end`" in traced.messages


def test_missing_fields_and_fields_of_another_type_are_rejected(traced: Traced) -> None:
    del traced.start("log")["parent"]
    traced.find("run.end")["duration"] = "long"
    assert "`behavior.start` needs `parent`" in traced.messages
    assert "`run.end` needs `duration`" in traced.messages


def test_a_wrong_duration_of_the_run_is_rejected(traced: Traced) -> None:
    traced.find("run.end")["duration"] = 7.0
    assert traced.broken == {"structure"}


def test_invalid_records_are_reported(traced: Traced) -> None:
    traced.records[3] = {"kind": 3}
    assert "a record needs `seq`, `t` and `kind`" in traced.messages

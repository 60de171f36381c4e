"""Flaky runs."""

from seoro.campaign.runs import End, Row
from seoro.campaign.statistics.flaky import find_flaky


def row(identity: str, end: End = End.PASSED, trace: str = "a") -> Row:
    """Row of a run."""
    return Row(run=1, id=identity, variant=1, repeat=1, seed=0, status=end, trace_sha=trace)


def test_other_verdicts_and_traces_of_one_id_are_found() -> None:
    steady = [row("same"), row("same"), row("once", trace="b")]
    crashed = [row("crashed"), row("crashed", End.ERROR, ""), row("crashed", End.CANCELLED, "c")]
    traces = [row("traces"), row("traces", trace="b")]
    verdicts = [row("verdicts"), row("verdicts", End.FAILED, "b")]
    found = find_flaky([*steady, *crashed, *traces, *verdicts])
    assert [(each.id, each.has_other_verdict) for each in found] == [("traces", False), ("verdicts", True)]
    assert found[1].rows == tuple(verdicts)

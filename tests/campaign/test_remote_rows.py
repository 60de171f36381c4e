"""Rows from other machines are checked."""

from __future__ import annotations

import json
from dataclasses import replace

import pytest

from seoro.campaign.identity import row_of
from seoro.campaign.remote.record import row_in, to_record
from seoro.campaign.remote.rows import Checker, InvalidRow
from seoro.campaign.runs import End, Planned, Row

PLANNED = Planned(7, 7, 1, 12, {"a": "1"}, "grid")
ROW = row_of(PLANNED, "d", "1", status=End.FAILED, values={"a": 1}, duration=2, folder="kept/000007", margin=0.5)


def read(line: str) -> Row:
    return Checker("d", "1").read(line.encode(), {7: PLANNED})


def test_a_row_of_a_given_run_is_read() -> None:
    assert read(ROW.to_line()) == ROW


def test_a_record_shows_a_message_and_has_the_row() -> None:
    strange = replace(ROW, reason='}, "row": {"', where="ä\udcff")
    record = to_record(strange, 1.5)
    shown = json.loads(record)
    assert (shown["kind"], shown["t"], shown["message"]) == ("log", 1.5, "run 7: failed")
    assert read(row_in(record).decode()) == Row.from_line(strange.to_line().encode("utf-8", "backslashreplace"))
    assert row_in(b'{"kind": "log"}\n') == b""


def changed(name: str, value: object) -> str:
    """Return the row with another value of a field."""
    return json.dumps({**json.loads(ROW.to_line()), name: value})


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("{", "invalid row"),
        ("[" * 100_000, "invalid row"),
        (replace(ROW, run=8).to_line(), "the run 8 was not given"),
        (replace(ROW, seed=13, id="0" * 16).to_line(), "was not given, or differs"),
        (replace(ROW, folder="../kept").to_line(), "unexpected folder `../kept`"),
        (replace(ROW, folder="kept/000008").to_line(), "unexpected folder"),
        (changed("status", "great"), "invalid row"),
        (changed("margin", "x"), "`margin` is a str"),
        (changed("attempt", True), "`attempt` is a bool"),
        (changed("coverage", [1]), "not a list of objects"),
    ],
)
def test_other_lines_are_refused(line: str, message: str) -> None:
    with pytest.raises(InvalidRow, match=message):
        read(line)

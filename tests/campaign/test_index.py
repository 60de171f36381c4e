"""Rows of a campaign in the order of their runs, and the files that are written from them."""

from pathlib import Path
from xml.etree import ElementTree as Xml

import pytest

from seoro.campaign.results import junit
from seoro.campaign.results.junit import write_junit
from seoro.campaign.results.table import write_table
from seoro.campaign.runs import End
from seoro.campaign.store import index
from seoro.campaign.store.folder import COORDINATOR, RUNS
from seoro.campaign.store.index import RowIndex
from seoro.errors import UsageError
from tests.campaign.generated import campaign_of, row, store


def test_rows_are_in_the_order_of_their_runs_once_each(tmp_path: Path) -> None:
    store(tmp_path, "w1", [row(5), row(2, reason="first")])
    store(tmp_path, "w2", [row(4, End.FAILED, reason="\ud800"), row(3, End.IMPOSSIBLE), row(1)])
    store(tmp_path, COORDINATOR, [row(2, End.ERROR)])
    rows = RowIndex(tmp_path)
    assert len(rows) == 4
    assert [(each.run, each.reason) for each in rows] == [(1, ""), (2, "first"), (4, "\ud800"), (5, "")]


def test_more_shards_than_open_files_are_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(index, "_MOST_OPEN", 2)
    for shard in range(5):
        store(tmp_path, f"w{shard}", [row(number) for number in range(shard, 40, 5)])
    assert [each.run for each in RowIndex(tmp_path)] == list(range(40))


def test_an_invalid_row_is_named(tmp_path: Path) -> None:
    store(tmp_path, "w1", [row(1)])
    shard = tmp_path / RUNS / "w1.jsonl"
    whole = shard.read_text()
    shard.write_text(whole + row(2).to_line().replace('"values"', '"walues"'))
    with pytest.raises(UsageError, match=rf"w1\.jsonl, byte {len(whole)}: invalid row"):
        list(RowIndex(tmp_path))
    shard.write_text(whole + "{}\n")
    with pytest.raises(UsageError, match=r"w1\.jsonl:2: invalid row"):
        RowIndex(tmp_path)


def test_columns_of_later_runs_are_in_the_table(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.campaign.results.table._FIRST", 1)
    store(tmp_path, "w1", [row(1, measured={"a": 1}), row(2, values={"load": 0.5}, measured={"b": 2})])
    lines = write_table(RowIndex(tmp_path), tmp_path).read_text().splitlines()
    assert len(lines) == 3
    assert lines[0].split(",")[6] == "load" and lines[0].endswith(",a,b")
    assert lines[1].endswith(",1,") and lines[2].endswith(",,2")


def test_junit_prefers_runs_that_did_not_pass(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(junit, "MOST_CASES", 3)
    store(tmp_path, "w1", [row(n, End.FAILED if n in (4, 6) else End.PASSED) for n in range(1, 8)])
    suites = Xml.parse(write_junit(RowIndex(tmp_path), tmp_path, campaign_of(7))).getroot()
    names = [str(case.get("name")).partition(":")[0] for case in suites.iter("testcase")]
    assert names == ["1", "4", "6"] and suites.get("failures") == "2"

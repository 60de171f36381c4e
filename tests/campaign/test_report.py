"""Reports of campaigns: counts, charts and pages."""

import json
import random
import re
from collections.abc import Iterable
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import pytest

from seoro.campaign.coverage.counts import MergedCoverage
from seoro.campaign.report.columns import MOST_BINS, OTHERS, Column
from seoro.campaign.report.grouping import Bucket, influence
from seoro.campaign.report.page import write_report
from seoro.campaign.report.summary import MOST_ROWS, summarize
from seoro.campaign.runs import End, Planned, Row
from seoro.campaign.stopping.rules import percent
from seoro.campaign.store.batches import read_batches
from seoro.campaign.store.covered import CoveredItem
from seoro.campaign.store.folder import (
    ASKED,
    RUNS,
    StrategyText,
    find_planned,
    read_campaign,
    write_campaign,
)
from seoro.campaign.work.measurements import reason_key
from seoro.cli.main import main
from tests.campaign.generated import generate, row, rows, store

EMPTY = {"meta", "br", "link", "input", "path", "rect"}
HOSTILE = "<script>alert(1)</script>&\"'\x00\ud800"


class Reader(HTMLParser):
    """Reads a page, and checks that its elements are closed."""

    def __init__(self) -> None:
        super().__init__()
        self.open: list[str] = []
        self.tags: list[str] = []
        self.headings: list[str] = []

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.append(tag)
        if tag not in EMPTY:
            self.open.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert tag in EMPTY or self.open.pop() == tag

    def handle_data(self, data: str) -> None:
        if self.open and self.open[-1] == "h2":
            self.headings.append(data)


def report(folder: Path, given: Iterable[Row]) -> tuple[str, Reader]:
    """Write the report of a campaign with these rows."""
    generate(folder, 0)
    (folder / RUNS / "worker.jsonl").write_text(
        "".join(each.to_line() for each in given), "utf-8", "backslashreplace"
    )
    text = write_report(folder).read_text(encoding="utf-8")
    reader = Reader()
    reader.feed(text)
    assert reader.open == []
    assert "script" not in reader.tags and "http" not in text, "it needs neither scripts nor a network"
    return text, reader


def test_many_numbers_are_counted_in_bins_exactly() -> None:
    numbers, draw = [number / 1000.0 for number in range(10_000)], random.Random(1)
    found = []
    for _ in range(2):
        draw.shuffle(numbers)
        column = Column()
        for number in numbers:
            column.add([number], [number < 1.0])
        assert len(column._bins) <= MOST_BINS
        found.append([(bucket.label, bucket.passed, bucket.failed) for bucket in column.grouping(10).buckets])
    assert found[0] == found[1], "in any order"
    assert found[0][0] == ("0 to 1", 0, 1000) and found[0][9] == ("9 to 10", 1000, 0)
    assert len(found[0]) == 10


@pytest.mark.parametrize(
    "numbers", [[1e-300 * n for n in range(40)], [1e280, *range(40)], [1e9 + n for n in range(40)]]
)
def test_all_numbers_of_a_column_are_counted(numbers: list[float]) -> None:
    column = Column()
    for number in [*numbers, float("nan"), float("inf")]:
        column.add([number], [False])
    grouping = column.grouping(8)
    assert sum(bucket.passed for bucket in grouping.buckets) == len(numbers) and len(grouping.buckets) <= 8


def test_texts_that_are_rare_are_counted_as_one() -> None:
    column = Column()
    for number in range(1000):
        column.add(["often" if number % 2 else f"text {number}"], [False])
    buckets = column.grouping(5).buckets
    assert buckets[0].label in ("often", OTHERS) and len(buckets) == 5
    assert sum(bucket.passed for bucket in buckets) == 1000


def test_the_parameter_that_matters_has_most_influence() -> None:
    assert influence([Bucket("a", 50, 50), Bucket("b", 100, 0)]) > 30.0
    assert abs(influence([Bucket("a", 50, 50), Bucket("b", 51, 49)])) < 1.0
    assert influence([Bucket("a", 50, 0), Bucket("b", 50, 0)]) == 0.0


def test_coverage_is_added_over_runs() -> None:
    merged = MergedCoverage()
    plain = {"item": "main.way", "kind": "cover", "unit": "m", "target": 1, "total": 4, "illegal": 0, "outside": 1}
    for bucket in ("0..1", "3..4", "0..1"):
        coverage = ({**plain, "buckets": {bucket: 1}}, {"kind": "record"})
        merged.add(row(1, coverage=coverage))
    (item,) = merged.items.values()
    samples = {bucket: counts.samples for bucket, counts in item.buckets.items()}
    assert (samples, item.reached, item.holes, item.outside) == ({"0..1": 2, "3..4": 1}, 2, ["1..3"], 3)


def test_a_summary_counts_each_run_once(tmp_path: Path) -> None:
    store(tmp_path, "w1", [*rows(2000), row(3001, End.IMPOSSIBLE)])
    store(tmp_path, "w2", rows(1000))
    found = summarize(read_batches(tmp_path), seed=1)
    assert (found.runs, found.impossible) == (2000, 1)
    failed = [each.run for each in rows(2000) if each.status is End.FAILED]
    assert found.ends[End.FAILED] == len(failed) == sum(group.count for group in found.failures.values())
    assert {group.example.run for group in found.failures.values()} <= set(failed)
    assert len(found.worst) == MOST_ROWS
    assert {each.run for _, each in found.worst[: len(failed)]} == set(failed)


def test_a_report_shows_what_fails_where_and_how_to_repeat_it(tmp_path: Path) -> None:
    generate(tmp_path, 1500)
    text = write_report(tmp_path).read_text(encoding="utf-8")
    failed = [each for each in rows(1500) if each.status is End.FAILED]
    assert f"{1500 - len(failed):,} passed, {len(failed)} failed" in text
    assert f"seoro campaign replay {tmp_path} {failed[0].run}<" in text
    order = [text.index(f"<h3>{name}") for name in ("load</h3>", "load (down) and ", "lights")]
    assert order == sorted(order), "what matters most comes first"
    assert f'href="kept/{failed[0].run:06}/"' in text
    reader = Reader()
    reader.feed(text)
    assert reader.headings == [
        "Failures by reason", "Pass rate by parameter", "Measurements", "Coverage", "Runs to look at",
        "Settings and machines",
    ]  # fmt: skip


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ([], "No run has a verdict."),
        ([row(1)], "100 % of 1 run passed"),
        ([row(number) for number in range(1, 301)], "100 % of 300 runs passed"),
        ([row(number, End.FAILED, reason="no") for number in range(1, 9)], "0 % of 8 runs passed"),
        ([row(1, End.ERROR, reason="lost"), row(2)], "1 run ended without a verdict"),
        ([row(1, End.ERROR, reason="lost"), row(2, End.CANCELLED)], "No run has a verdict."),
        ([row(n, values={f"p{p}": n * p for p in range(50)}) for n in range(30)], "44 more parameters"),
        ([row(1, measured={"a": None, "b": [1], "c": True, "d": "x", "e": float("inf")})], "100 %"),
    ],
)
def test_a_report_has_any_number_of_runs(given: list[Row], expected: str, tmp_path: Path) -> None:
    assert expected in report(tmp_path, given)[0]


def test_rare_failures_are_not_rounded_away() -> None:
    shares = (0.0, 1.0, 0.5, 0.99997, 2e-7, 1.0 / 3.0)
    assert [percent(share) for share in shares] == ["0 %", "100 %", "50 %", "99.997 %", "0.00002 %", "33.33 %"]


def test_intervals_are_shown_for_samples_only(tmp_path: Path) -> None:
    generate(tmp_path, 30)
    assert "95 % interval:" in write_report(tmp_path).read_text(encoding="utf-8")
    campaign = read_campaign(tmp_path)
    write_campaign(tmp_path, campaign.model_copy(update={"budget": 1.0}))
    assert "95 % interval, valid at any time:" in write_report(tmp_path).read_text(encoding="utf-8")
    write_campaign(tmp_path, campaign.model_copy(update={"is_sample": False}))
    text = write_report(tmp_path).read_text(encoding="utf-8")
    assert "95 % interval:" not in text and "estimates no probability" in text


def test_hostile_and_long_texts_stay_text(tmp_path: Path) -> None:
    values = {f"{HOSTILE}{number}": HOSTILE for number in range(2)} | {"long": "x" * 5000}
    named = {"reason": HOSTILE + "y" * 5000, "reason_key": HOSTILE, "where": HOSTILE, "folder": HOSTILE}
    failed = row(1, End.FAILED, values=values, host=HOSTILE, measured={HOSTILE: 1.0}, **named)
    text, _ = report(tmp_path, [failed, row(2, values={HOSTILE: "other"}, measured={HOSTILE: 2.0})])
    assert "&lt;script&gt;" in text and "\x00" not in text
    assert len(text) < 60_000


def test_planned_runs_are_found_by_number(tmp_path: Path) -> None:
    planned = [Planned(number, number, 1, 7, {"way": f"{number}m"}, "grid") for number in range(1, 50)]
    lines = [each.to_line() for each in planned]
    lines[4] = json.dumps(dict(reversed(json.loads(lines[4]).items()))) + "\n"
    (tmp_path / ASKED).write_text("".join(lines))
    assert find_planned(tmp_path, {5, 17, 99}) == {5: planned[4], 17: planned[16]}


def test_the_command_writes_all_results(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    generate(tmp_path, 20)
    assert main(["campaign", "report", str(tmp_path)]) == 0
    out = capsys.readouterr().out.split()
    assert [Path(path).name for path in out] == ["report.html", "runs.csv", "runs.parquet", "test.xml"]
    parquet = pytest.importorskip("pyarrow.parquet")
    table = parquet.read_table(tmp_path / "runs.parquet")
    assert table.num_rows == 20 and str(table.schema.field("load").type) == "double"
    assert str(table.schema.field("id").type) == "string"
    assert main(["campaign", "report", str(tmp_path / "none")]) == 2
    assert "is not the folder of a campaign" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("reason", "key"),
    [
        ("timeout: still running after 26 s", "timeout: still running after # s"),
        ("turtlebot4 moved into 'box' at (-1.78, 2e-05)", "turtlebot4 moved into 'box' at (#, #)"),
        ("tb12 is 3.5 m from arm_2", "tb12 is # m from arm_2"),
    ],
)
def test_a_kind_of_failure_keeps_names(reason: str, key: str) -> None:
    assert reason_key(reason) == key


@pytest.mark.parametrize(
    ("cells", "kinds"),
    [
        ("", [("2", 3), ("1", 1)]),
        ("robot.a,duration", [("0.8..0.92", 3), ("0.44..0.56", 1), ("0.68..0.8", 2)]),
    ],
)
def test_the_worst_run_of_each_kind_is_shown(tmp_path: Path, cells: str, kinds: list[tuple[str, int]]) -> None:
    def covering(number: int, bucket: str, end: End, margin: float) -> Row:
        item = {"item": "main.a", "kind": "cover", "unit": "", "target": 1, "total": 3, "illegal": 0, "outside": 0}
        return replace(
            row(number, end),
            margin=margin,
            duration=2.0,
            coverage=(item | {"buckets": {bucket: 1}},),
            measured={"robot.a": 0.5 + 0.2 * (number - 1)},
        )

    given = [
        covering(1, "1", End.PASSED, 0.1),
        covering(2, "1", End.PASSED, 0.3),
        covering(3, "2", End.FAILED, -0.2),
        covering(4, "3", End.ERROR, -1.0),
    ]
    generate(tmp_path, 0)
    items = (CoveredItem(item="main.a", definition=""),)
    text = StrategyText(name="map-elites", options={"cells": cells})
    write_campaign(tmp_path, read_campaign(tmp_path).model_copy(update={"strategy": text, "items": items}))
    store(tmp_path, "worker", given)
    page = write_report(tmp_path).read_text()
    table = page.partition("Worst run of each kind")[2].partition("</table>")[0]
    found = re.findall(r"<tr><td>([^<]*)</td>(?:<td>[^<]*</td>)?<td class=\"number\">(\d+)", table)
    assert [(kind, int(run)) for kind, run in found] == kinds


def test_values_that_failures_have_in_common_are_named(tmp_path: Path) -> None:
    given = []
    for number in range(1, 41):
        values = {"load": number / 40, "floor": "wood" if number % 2 else "tile", "any": number % 10, "same": "x"}
        has_failed = number > 26 and number % 2 == 1
        end, reason = (End.FAILED, "stuck after 3 m") if has_failed else (End.PASSED, "")
        key = reason and "stuck after # m"
        given.append(replace(row(number, end), values=values, reason=reason, reason_key=key))
    for folder in ("many", "few"):
        (tmp_path / folder).mkdir()
    text, _ = report(tmp_path / "many", given)
    assert "<h3>stuck after 3 m</h3>" in text, "it is the reason of all"
    assert "<p>All have load from 0.675 to 0.975, floor = wood.</p>" in text
    few, _ = report(tmp_path / "few", given[:30])
    assert "All have" not in few, "two failures have much in common by chance"


@pytest.mark.parametrize("outliers", [1, 4, 5])
def test_a_few_outliers_do_not_hide_what_failures_have_in_common(tmp_path: Path, outliers: int) -> None:
    given = []
    for number in range(1, 401):
        is_outlier = number <= outliers
        has_failed = is_outlier or number > 320 + outliers
        values = {"load": number / 400, "floor": "tile" if is_outlier else "wood", "other": number % 2}
        end, reason = (End.FAILED, "stuck") if has_failed else (End.PASSED, "")
        values |= {} if has_failed else {"floor": "stone" if number % 2 else "wood"}
        given.append(replace(row(number, end), values=values, reason=reason, reason_key=reason))
    text, _ = report(tmp_path, given)
    assert "All have" not in text
    found = re.findall(r"<p>(\d+) of 80 have load from ([\d.]+) to 1, floor = wood.</p>", text)
    if outliers > 4:
        assert found == [], "more than 5 % are others"
    else:
        [(count, low)] = found
        assert int(count) == 80 - outliers
        assert 0.75 <= float(low) <= 0.815


def test_values_that_fail_always_are_named_beside_rare_ones(tmp_path: Path) -> None:
    given = []
    for number in range(1, 301):
        width = (0.2, 0.4, 0.8)[number % 3]
        has_failed = width == 0.2 or number in (1, 2, 4)
        end, reason = (End.FAILED, "stuck") if has_failed else (End.PASSED, "")
        given.append(replace(row(number, end), values={"width": width}, reason=reason, reason_key=reason))
    text, _ = report(tmp_path, given)
    assert "<p>100 of 103 have width = 0.2.</p>" in text


def test_measurements_have_their_median_and_the_range_of_most_runs(tmp_path: Path) -> None:
    given = [
        replace(row(number, End.PASSED), measured={"robot.speed": number / 100, "robot.goals": number % 2})
        for number in range(1, 201)
    ]
    text, _ = report(tmp_path, given)
    assert re.search(r"median 1(\.0\d*)?, 90 % from 0\.10?\d* to 1\.9\d*<", text)
    assert text.count("median") == 1, "two values need none"

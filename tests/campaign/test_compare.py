"""Comparison of campaigns."""

from __future__ import annotations

import json
import tracemalloc
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest

import seoro.campaign as sc
from seoro.campaign.comparison.page import write_comparison
from seoro.campaign.comparison.pairs import join
from seoro.campaign.runs import End, Row
from seoro.campaign.store.folder import StrategyText
from seoro.campaign.store.index import RowIndex
from seoro.cli.main import main
from seoro.errors import UsageError
from tests.campaign.compared import draw_ends, rows, write

PASSED, FAILED = End.PASSED, End.FAILED


def compared(tmp_path: Path, before: list[Row], after: list[Row], **options: float) -> sc.Comparison:
    """Compare two campaigns with these rows."""
    first, second = write(tmp_path / "before", before), write(tmp_path / "after", after)
    return sc.compare(first, second, **options)


def test_newly_failing_runs_make_a_campaign_worse(tmp_path: Path) -> None:
    found = compared(tmp_path, list(rows([PASSED] * 200)), list(rows([FAILED] * 6 + [PASSED] * 194)))
    assert found.outcome is sc.Outcome.WORSE and found.is_paired and found.p == pytest.approx(2 / 2**6)
    assert [pair.after.run for pair in found.failing] == [1, 2, 3, 4, 5, 6] and not found.passing
    assert found.command(found.failing[2]) == f"seoro campaign replay {tmp_path / 'after'} 3"
    assert found.equal == 200 and found.counts == ((200, 200), (194, 200))


def test_a_campaign_is_not_worse_if_the_drop_is_less_than_the_margin(tmp_path: Path) -> None:
    same = list(rows([PASSED] * 199 + [FAILED]))
    assert compared(tmp_path, same, same).outcome is sc.Outcome.NOT_WORSE
    narrow = sc.compare(tmp_path / "before", tmp_path / "after", margin=0.01)
    assert narrow.outcome is sc.Outcome.UNDECIDED and "by up to 1.33 %; more runs narrow this" in narrow.reason
    with pytest.raises(UsageError, match="invalid `margin`"):
        sc.compare(tmp_path / "before", tmp_path / "after", margin=2)


def test_runs_are_joined_by_values_seed_and_repeat(tmp_path: Path) -> None:
    before = list(rows([PASSED] * 100))
    after = [replace(row, run=101 - row.run, status=FAILED if row.run < 3 else PASSED) for row in before]
    extra = [replace(row, run=row.run + 100, repeat=2) for row in before[:20]]
    found = compared(tmp_path, before, [*after, *extra])
    assert len(found.joined.pairs) == 100 and {pair.after.run for pair in found.failing} == {99, 100}
    assert found.counts == ((100, 100), (98, 100))


def test_campaigns_without_common_runs_are_compared_as_independent(tmp_path: Path) -> None:
    before, after = list(rows([PASSED] * 300)), list(rows([PASSED] * 280 + [FAILED] * 20, first_seed=1000))
    found = compared(tmp_path, before, after)
    assert found.outcome is sc.Outcome.WORSE and not found.is_paired and not found.joined.pairs
    grid = {"is_sample": False, "strategy": StrategyText(name="grid", options={"levels": 3})}
    other = sc.compare(tmp_path / "before", write(tmp_path / "grid", after, **grid))
    assert other.outcome is sc.Outcome.UNDECIDED and "are not independent random samples" in other.reason
    assert ("strategy", "random", "grid (levels 3)") in [
        (each.name, each.before, each.after) for each in other.differences
    ]


def test_runs_that_lost_their_verdict_leave_the_outcome_open(tmp_path: Path) -> None:
    found = compared(tmp_path, list(rows([PASSED] * 300)), list(rows([End.ERROR] + [PASSED] * 299)))
    assert found.outcome is sc.Outcome.UNDECIDED and [pair.after.run for pair in found.lost] == [1]
    nothing = sc.compare(tmp_path / "before", write(tmp_path / "empty", []))
    assert nothing.outcome is sc.Outcome.UNDECIDED and nothing.reason == "a campaign has no run with a verdict"


def test_measurements_change_by_variant(tmp_path: Path) -> None:
    random = Random(1)
    before, after = [], []
    for row in rows([PASSED] * 60):
        for repeat in (1, 2):
            single = replace(row, run=2 * row.run + repeat, repeat=repeat)
            speed, noise = random.gauss(1.0, 0.2), random.gauss(0.0, 1.0)
            before.append(replace(single, measured={"robot.speed": speed, "noise": noise, "name": "x", "old": 1}))
            measured = {"robot.speed": speed - 0.1, "noise": random.gauss(0.0, 1.0), "name": "y", "new": 2}
            after.append(replace(single, measured=measured))
    found = {each.name: each for each in compared(tmp_path, before, after).measurements}
    assert set(found) == {"duration", "robot.speed", "noise"}
    slower = found["robot.speed"]
    assert slower.variants == 60 and slower.falling == 60 and slower.is_significant
    assert slower.change == pytest.approx(-0.1) and slower.bounds.low == pytest.approx(-0.1)
    assert not found["noise"].is_significant and found["noise"].bounds.low < 0.0 < found["noise"].bounds.high
    assert found["duration"].p == 1.0 and found["duration"].rising == 0


def test_pairs_take_few_bytes_until_they_are_read(tmp_path: Path) -> None:
    measured = {f"robot.{name}": 1.0 for name in "abcdefgh"}
    given = [replace(row, measured=measured) for row in rows([PASSED, FAILED] * 1500)]
    first, second = write(tmp_path / "before", given), write(tmp_path / "after", given)
    del given
    tracemalloc.start()
    joined = join(first, second)
    size, _ = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    assert len(joined.pairs) == joined.equal == 3000 and size < 1_500_000
    [pair] = joined.pairs[2999:]
    assert (pair.before.run, pair.after.run, pair.values) == (3000, 3000, {"load": 3.0})


def test_a_page_reads_only_the_runs_that_it_lists(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = compared(tmp_path, list(rows([PASSED] * 900)), list(rows([FAILED] * 300 + [PASSED] * 600)))
    read: list[int] = []
    find = RowIndex.find

    def counted(self: RowIndex, run: int) -> Row | None:
        read.append(run)
        return find(self, run)

    monkeypatch.setattr(RowIndex, "find", counted)
    write_comparison(found, tmp_path / "page.html")
    assert read == list(range(1, 201))
    assert "Still passing by" in (tmp_path / "page.html").read_text()


def test_the_command_line_has_an_exit_status_a_page_and_json(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    write(Path("main"), rows([PASSED] * 300))
    write(Path("branch"), rows([FAILED] * 12 + [PASSED] * 288), version="1", until=("first failure",))
    assert main(["campaign", "compare", "main", "branch", "-o", "compare.html"]) == 1
    out = capsys.readouterr().out
    assert "worse: branch compared with main" in out and "12 newly failing, 0 newly passing" in out
    assert "    seoro campaign replay branch 10\n  and 2 more" in out and "compare.html" in out
    assert "so errors are more frequent than stated" in out and "first failure" in out.partition("what differs")[2]
    page = Path("compare.html").read_text()
    assert "&lt;too&gt; slow" in page and "<too>" not in page and "<script" not in page and "<svg" in page
    assert main(["campaign", "compare", "main", "main", "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["outcome"] == "not worse"
    assert main(["campaign", "compare", "main", "main", "--margin", "0.1%"]) == 3
    assert main(["campaign", "compare", "main", "nothing"]) == 2


def test_notebooks_show_the_outcome(tmp_path: Path) -> None:
    found = compared(tmp_path, list(rows([PASSED] * 9)), list(rows([PASSED] * 9)))
    assert "undecided" in found._repr_html_() and repr(found).startswith("<Comparison: undecided")


@pytest.mark.more
def test_300_pairs_find_a_regression_of_3_percent_and_raise_few_alarms(tmp_path: Path) -> None:
    random, worse, alarms = Random(7), 0, 0
    for number in range(24):
        (first, second), (stable, unstable) = (
            draw_ends(random, 300, broken=0.03),
            draw_ends(random, 300, unstable=0.5),
        )
        for name, ends in zip("abcd", (first, second, stable, unstable), strict=True):
            write(tmp_path / f"{name}{number}", rows(ends))
        worse += sc.compare(tmp_path / f"a{number}", tmp_path / f"b{number}").outcome is sc.Outcome.WORSE
        alarms += sc.compare(tmp_path / f"c{number}", tmp_path / f"d{number}").outcome is sc.Outcome.WORSE
    assert worse >= 0.8 * 24 and alarms <= 0.05 * 24

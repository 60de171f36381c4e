"""Stopping rules: their grammar, their decisions, and campaigns that they end."""

import json
import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from pathlib import Path
from random import Random

import pytest

from seoro.campaign.results.tally import Tally
from seoro.campaign.runs import End, Row
from seoro.campaign.statistics.rates import live_bounds
from seoro.campaign.statistics.sequential_test import Decision, SequentialTest
from seoro.campaign.stopping.grammar import parse_rule
from seoro.campaign.stopping.rate import Rate, Validity
from seoro.campaign.stopping.rules import Accuracy, Failures, RateBound, RateTest, Rule
from seoro.campaign.stopping.watch import Watch
from seoro.cli.campaign_stopping import status_of_test
from seoro.cli.main import main
from seoro.errors import UsageError


@pytest.mark.parametrize(
    ("text", "rule"),
    [
        ("rate +- 2%", Accuracy(0.02)),
        ("rate ± 0.02", Accuracy(0.02)),
        ("  rate  +-2 % ", Accuracy(0.02)),
        ("rate >= 0.95 vs 0.90", RateTest(SequentialTest(0.95, 0.9, 0.05))),
        ("rate >= 95% vs 90% errors 1%", RateTest(SequentialTest(0.95, 0.9, 0.01))),
        ("rate >= 95%", RateBound(0.95)),
        ("first failure", Failures(1)),
        ("10 failures", Failures(10)),
    ],
)
def test_rules(text: str, rule: Rule) -> None:
    assert parse_rule(text) == rule


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("rate", "unknown rule"),
        ("rate >= 100%", "expected a rate between 0 and 100 %, found 100%"),
        ("rate >= 0.95 errors 1%", "unknown rule"),
        ("rate +- 2% please", "unknown rule"),
        ("rate +- 0%", "expected an accuracy between 0 and 50 %, found 0%"),
        ("rate +- 2", "expected an accuracy between 0 and 50 %, found 2"),
        ("rate >= 0.90 vs 0.95", "expected 0 < second rate < first rate < 1"),
        ("rate >= 1 vs 0.95", "expected 0 < second rate < first rate < 1"),
        ("rate >= 0.95 vs 0.9 errors 0.6", "expected errors between 0 and 50 %, found 0.6"),
        ("0 failures", "expected at least one failure"),
    ],
)
def test_invalid_rules(text: str, message: str) -> None:
    with pytest.raises(UsageError, match=re.escape(f"invalid stopping rule `{text}`: {message}")):
        parse_rule(text)


def row(number: int, end: End) -> Row:
    """Row of a run."""
    return Row(run=number, id="", variant=number, repeat=1, seed=0, status=end)


def fed(watch: Watch, rows: Iterable[Row]) -> Watch:
    """The watch after rows."""
    for each in rows:
        watch.record(each)
    return watch


def test_accuracy_is_reached_with_the_bounds_that_are_shown() -> None:
    rule = Accuracy(0.02)
    runs = next(runs for runs in range(1, 10_000) if rule.check(runs, 0) is not None)
    for each, is_wide in ((runs - 1, True), (runs, False)):
        bounds = live_bounds(each, each)
        assert ((bounds.high - bounds.low) / 2.0 > 0.02) is is_wide


def test_a_rule_decides_at_the_same_run_in_any_order() -> None:
    random = Random(3)
    rows = [row(number, End.PASSED if random.random() < 0.97 else End.FAILED) for number in range(1, 301)]
    in_order = fed(Watch([parse_rule("rate >= 0.97 vs 0.90")]), rows)
    assert in_order.stop is not None
    assert in_order.stop.decision is Decision.GOOD
    assert re.fullmatch(r"the pass rate is 97 % rather than 90 %, after \d+ runs", in_order.stop.reason)
    for start in range(0, 300, 20):  # as by several workers
        random.shuffle(part := rows[start : start + 20])
        rows[start : start + 20] = part
    assert fed(Watch([parse_rule("rate >= 0.97 vs 0.90")]), rows).stop == in_order.stop


def test_a_bound_of_the_rate_decides_when_the_interval_excludes_it() -> None:
    rule = RateBound(0.95)
    assert rule.check(100, 0) is None
    good, bad = rule.check(160, 0), rule.check(20, 8)
    assert good is not None and good.decision is Decision.GOOD and good.reason == "the pass rate is at least 95 %"
    assert bad is not None and bad.decision is Decision.BAD


def test_runs_count_once_and_only_with_a_verdict() -> None:
    ends = [End.PASSED, End.ERROR, End.IMPOSSIBLE, End.CANCELLED, End.FAILED, End.PASSED]
    rows = [row(number, end) for number, end in enumerate(ends, start=1)]
    watch = fed(Watch(), [rows[5], rows[0], rows[0], rows[5], *rows[1:4]])
    assert (watch.passed, watch.failed) == (1, 0), "run 5 has not ended"
    fed(watch, rows)
    assert (watch.passed, watch.failed) == (2, 1)


def test_rates_are_told_with_their_intervals() -> None:
    assert str(Rate(2, 1, Validity.ALWAYS)) == "pass rate 66.67 % (6.68 to 99.58 %, valid at any time)"
    assert str(Rate(2, 1, Validity.FIXED)) == "pass rate 66.67 % (9.43 to 99.16 %, 95 % confidence)"
    assert (
        str(Rate(2, 1, Validity.NONE)) == "pass rate 66.67 % of 3 runs"
        and Rate(2, 1, Validity.NONE).bounds is None
    )
    assert str(Rate(0, 0, Validity.ALWAYS)) == "pass rate unknown: no run has a verdict"


def test_the_budget_ends_a_campaign() -> None:
    now = 5.0
    watch = Watch(budget=60.0, clock=lambda: now)
    assert not watch.is_enough()
    now = 65.0
    assert watch.is_enough()
    assert watch.stop is not None
    assert watch.stop.reason == "the budget is used up"


TEXT = """import osc.helpers
scenario main:
    load: float
    keep(load in [0.0..1.0])
    do compare(load, "<", {limit})
"""
Run = Callable[..., int]


@pytest.fixture
def run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Run:
    monkeypatch.chdir(tmp_path)

    def run_campaign(limit: float, *arguments: str) -> int:
        (tmp_path / "main.osc").write_text(TEXT.format(limit=limit))
        options = ("--clock", "virtual", "--seed", "5", "-o", "out", "-j", "1", "--overwrite")
        return main(["campaign", "run", "main.osc", *options, *arguments])

    return run_campaign


def test_a_campaign_ends_with_a_decision(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(0.97, "--strategy", "random", "--until", "rate >= 0.95 vs 0.80") == 0
    out = capsys.readouterr().out
    assert "  stopped: the pass rate is 95 % rather than 80 %, after " in out
    assert "valid at any time)" in out


@pytest.mark.parametrize(
    ("ends", "status"),
    [
        ([End.PASSED] * 40, 0),
        ([End.FAILED] * 4, 1),
        ([End.PASSED] * 3, 3),
        ([End.ERROR] + [End.PASSED] * 40, 3),
    ],
)
def test_the_exit_status_is_the_decision(ends: list[End], status: int) -> None:
    watch, tally = Watch([parse_rule("rate >= 0.95 vs 0.80")]), Tally()
    for number, end in enumerate(ends, start=1):
        watch.record(row(number, end))
        tally.count(row(number, end))
    assert status_of_test(watch, tally) == status


def test_rules_hold_when_a_campaign_is_resumed(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(0.5, "--strategy", "random", "--until", "first failure", "--budget", "1h") == 1
    assert "  stopped: first failure, after " in capsys.readouterr().out
    stored = json.loads(Path("out/campaign.json").read_text(encoding="utf-8"))
    assert (stored["until"], stored["budget"]) == (["first failure"], 3600.0)
    before = Path("out/asked.jsonl").read_bytes()
    assert main(["campaign", "status", "out"]) == 0
    assert "valid at any time)\n  stopped: first failure, after " in capsys.readouterr().out
    assert main(["campaign", "resume", "out", "-j", "1"]) == 1
    assert "  stopped: first failure, after " in capsys.readouterr().out
    assert Path("out/asked.jsonl").read_bytes() == before, "no run is planned after the decision"


def test_only_a_fixed_number_of_runs_has_an_exact_interval(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(2.0, "--strategy", "random", "--runs", "5") == 0
    assert "5 of 5 runs: 5 passed, pass rate 100 % (47.82 to 100 %, 95 % confidence)" in capsys.readouterr().out
    assert main(["campaign", "status", "out"]) == 0
    assert "same id" not in capsys.readouterr().out
    (shard,) = Path("out/runs").glob("*.jsonl")
    first = Row.from_line(shard.read_text(encoding="utf-8").splitlines()[0])
    with Path("out/runs/other.jsonl").open("w", encoding="utf-8") as file:
        file.write(replace(first, run=6, status=End.FAILED).to_line())
    assert main(["campaign", "status", "out"]) == 0
    assert "  runs 1, 6 have the same id, but other verdicts" in capsys.readouterr().out
    Path("out/runs/other.jsonl").unlink()
    assert main(["campaign", "resume", "out", "--runs", "8", "-j", "1"]) == 0
    out = capsys.readouterr().out
    assert "8 of 8 runs: 8 passed, pass rate 100 %" in out
    assert "95 % confidence" not in out


def test_grids_have_no_rate(run: Run, capsys: pytest.CaptureFixture[str]) -> None:
    assert run(2.0, "--levels", "3") == 0
    assert "pass rate" not in capsys.readouterr().out
    assert run(2.0, "--levels", "3", "--until", "rate +- 2%") == 2
    err = capsys.readouterr().err
    assert (
        "the stopping rule `rate +- 2%` needs runs that are independent of each other: the strategy `grid`" in err
    )
    assert run(2.0, "--strategy", "random", "--repeat", "2", "--until", "rate +- 2%") == 2
    assert "repeats with `--repeat 2` share values" in capsys.readouterr().err

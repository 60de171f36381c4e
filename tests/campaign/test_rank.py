"""The fewest runs that keep the coverage of a campaign."""

import json
import random
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from seoro.campaign.ranking import Ranking, greedy
from seoro.campaign.runs import End, Row
from seoro.cli.main import main

TEXT = """import osc.types
import osc.helpers

# seoro: timeout 60s
scenario main:
    load: int
    keep(load in [1..6])
    mode: string
    keep(mode in ["a", "b"])
    cover(load, range: [1..7], every: 2)
    cover(mode)
    do serial:
        wait elapsed(1s)
        compare(load, "<", 6)
"""


def item(name: str, *buckets: str, kind: str = "cover", total: int | None = 9) -> dict[str, Any]:
    return {"item": name, "kind": kind, "buckets": dict.fromkeys(buckets, 1), "total": total}


def row(number: int, *items: Mapping[str, Any], status: End = End.PASSED, reason: str = "") -> Row:
    return Row(number, "", number, 1, 1, status, coverage=items, reason=reason, reason_key=reason)


def ranked(*rows: Row, failures: bool = False) -> list[tuple[int, int, int]]:
    ranking = Ranking(failures=failures)
    for each in rows:
        ranking.add(each)
    return [(each.run, each.new, each.total) for each in ranking.chosen()]


def test_runs_with_most_new_buckets_come_first() -> None:
    rows = [
        row(1, item("a", "1")),
        row(2, item("a", "1", "2"), item("b", "1")),
        row(3, item("b", "2"), item("a", "2")),
        row(4, item("a", "3", "4", "5", "6")),
        row(5, item("a", "1", "2"), item("b", "1")),
    ]
    assert ranked(*rows) == [(4, 4, 4), (2, 3, 7), (3, 1, 8)] == ranked(*reversed(rows))


def test_runs_that_later_ones_replace_are_left_out() -> None:
    rows = [
        row(1, item("a", "1", "2", "3", "4")),
        row(2, item("a", "1", "2", "5")),
        row(3, item("a", "3", "4", "6")),
    ]
    assert ranked(*rows) == [(2, 3, 3), (3, 3, 6)]


def test_only_buckets_of_runs_with_a_verdict_count() -> None:
    rows = [
        row(1, item("a", "1"), status=End.ERROR),
        row(2, item("a", "0.123", kind="record"), item("b", "0.5", total=None)),
        row(3, item("a", "2"), status=End.FAILED, reason="late"),
        row(4, item("a", "2")),
    ]
    assert ranked(*rows) == [(4, 1, 1)], "a run that passed is preferred"


def test_each_failure_is_kept_on_request() -> None:
    rows = [
        row(1, item("a", "1", "2", "3")),
        row(2, item("a", "1"), status=End.FAILED, reason="late"),
        row(3, item("a", "1"), status=End.FAILED, reason="late"),
        row(4, status=End.FAILED, reason="fallen"),
    ]
    assert ranked(*rows, failures=True) == [(2, 1, 1), (4, 0, 1), (1, 2, 3)]


def test_the_choice_is_nearly_as_small_as_possible() -> None:
    draw = random.Random(1)
    parts = dict.fromkeys(range(1, 21), 0)  # the least: each bucket in one of 20 runs
    for bucket in range(300):
        parts[draw.randint(1, 20)] |= 1 << bucket
    noise = {number: sum(1 << bucket for bucket in draw.sample(range(300), 12)) for number in range(21, 2000)}
    chosen = dict(greedy({**noise, **parts}))
    union = 0
    for found in chosen.values():
        union |= found
    assert union == (1 << 300) - 1 and len(chosen) <= 40


def test_the_chosen_runs_become_a_test_suite(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    command = ["campaign", "run", "main.osc", "--strategy", "random", "--runs", "20", "--clock", "virtual"]
    assert main([*command, "--constrain", "load >= 2", "--seed", "1", "-j", "1"]) == 1
    capsys.readouterr()
    assert main(["campaign", "rank", "campaign"]) == 0
    assert "main.osc: 3 of 20 runs keep all 5 buckets" in capsys.readouterr().out
    Path("smoke").mkdir()
    Path("smoke/main_000099.osc").write_text("# Written by seoro campaign.\n")
    Path("smoke/main_own.osc").write_text("")
    assert main(["campaign", "rank", "campaign", "--failures", "--emit", "smoke", "--json"]) == 0
    out, err = capsys.readouterr()
    chosen = [json.loads(line) for line in out.splitlines()]
    assert err.splitlines()[-2:] == [f"  smoke/main_*.osc  {len(chosen)} files", "  pytest smoke"]
    files = sorted(path.name for path in Path("smoke").glob("*.osc"))
    assert files == sorted([*(f"main_{each['run']:06}.osc" for each in chosen), "main_own.osc"])
    statuses = {
        each["run"]: main(["exec", f"smoke/main_{each['run']:06}.osc", "--clock", "virtual"]) for each in chosen
    }
    assert statuses == {each["run"]: int(bool(each["failure"])) for each in chosen}
    assert set(statuses.values()) == {0, 1}
    assert "# seoro: constrain load >= 2\n" in Path("smoke", files[0]).read_text()


LAB = """simulators:
  hall: {simulator: mujoco, world: hall}
robots:
  tb1: {in: hall, as: turtlebot4, type: turtlebot4}
"""
DRIVE = """import osc.driving
import osc.helpers

scenario drive:
    robot: differential_drive_robot
    pace: speed
    keep(pace in [0.1mps, 0.2mps])
    cover(pace, unit: mps, range: [0..0.3], every: 0.15, event: start)
    do serial:
        robot.drive(linear: pace, duration: 0.2s)
        compare(pace, "<", 0.15mps)
"""


@pytest.mark.more
def test_the_suite_of_a_campaign_in_a_lab_runs_in_the_lab(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capfd: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("drive.osc").write_text(DRIVE)
    Path("lab.yaml").write_text(LAB)
    assert main(["campaign", "run", "drive.osc", "--lab", "lab.yaml", "--seed", "1", "-j", "1"]) == 1
    assert main(["campaign", "rank", "campaign", "--emit", "smoke"]) == 0
    assert capfd.readouterr().out.endswith("  smoke/conftest.py  the options of the campaign\n  pytest smoke\n")
    status = subprocess.run([sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "smoke"], check=False)
    assert status.returncode == 1
    out = capfd.readouterr().out
    assert "1 failed, 1 passed" in out and "0.2mps < 0.15mps" in out


def test_a_campaign_without_coverage_is_refused(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    text = "\n".join(line for line in TEXT.splitlines() if "cover" not in line)
    Path("main.osc").write_text(text + "\n")
    main(["campaign", "run", "main.osc", "--set", "load=1", "--clock", "virtual", "--seed", "1", "-j", "1"])
    assert main(["campaign", "rank", "campaign"]) == 2
    assert "campaign has no coverage to keep" in capsys.readouterr().err

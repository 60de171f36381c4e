"""Coverage across the runs of campaigns, and runs directed at lacking buckets."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from seoro.campaign.coverage.counts import MergedCoverage
from seoro.campaign.coverage.drawing import Excluded, InputSpace
from seoro.campaign.coverage.items import covered_items
from seoro.campaign.runs import OF_THE_MACHINE, End, Point, Row
from seoro.campaign.space.finding import find_axes
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Told
from seoro.campaign.strategies.cover import Cover
from seoro.cli.main import main
from seoro.embed import load
from seoro.errors import UsageError
from seoro.lang.frontend import lower
from tests.campaign.test_campaigns import table

GRID = """import osc.types
import osc.helpers

scenario main:
    a: int
    keep(a in [0..9])
    b: float
    keep(b in [0.0..10.0])
    keep(a < 8 or b < 0.0)
    cover(a, event: start)
    cover(b, range: [0..10], every: 1, event: start)
    cover(both, items: [a, b], event: start)
    do serial:
        wait elapsed(1s)
        compare(b, "<", 9.5)
"""
INVOKING = """import osc.helpers

scenario greet:
    volume: int
    keep(volume < 5)
    do log("hello")

scenario main:
    loud: int
    keep(loud in [1, 4, 6])
    cover(loud)
    do serial:
        greet(loud)
        one_of:
            greet(loud + 1)
            log("hello")
"""
KINDS = """import osc.types

enum light: [red, amber, green]

struct storm:
    wind: speed
    keep(wind in [5kph..20kph])

scenario main:
    pace: speed
    keep(pace in [-1mps..5mps])
    n: int
    keep(n in [0, 2, 5])
    gap: length with:
        keep(it in [0.1m, 0.25m])
        cover(gap, unit: cm)
    now: light
    is_wet: bool
    weather: storm
    name: string
    keep(name in ["a", "b c"])
    var steps: int = 0
    cover(pace, unit: kph, range: [-3..18], every: 7)
    cover(uneven, expression: pace, unit: mps, buckets: [-1, 0, 0, 2.5, inf])
    cover(n, ignore: n == 2)
    cover(now)
    cover(is_wet)
    cover(name)
    cover(wind, expression: weather.wind, unit: kmph)
    cover(total, expression: n * 2 + 1, range: [0..11], every: 4)
    cover(both, items: [now, is_wet])
    cover(steps, range: [0..3])
    cover(calls, expression: steps + n, range: [0..3])
    record(pace_again, expression: pace, unit: mps)
    do wait elapsed(1s)
"""


def inputs(folder: Path, text: str) -> InputSpace:
    """Return the bins of a scenario."""
    (folder / "main.osc").write_text(text)
    scenario = load(folder / "main.osc")
    plan = lower(scenario.checked, None)
    return InputSpace(scenario, None, {}, (), find_axes(plan, ()), plan)


def test_values_drawn_for_a_bin_are_in_it(tmp_path: Path) -> None:
    space = inputs(tmp_path, KINDS)
    counts: dict[str, int] = {}
    for number, each in enumerate(space.bins):
        drawn = space.draw(each, number)
        assert (each.item, each.bucket) in drawn.samples, each
        counts[each.item] = counts.get(each.item, 0) + 1
    assert counts == {
        "main.gap": 2, "main.pace": 3, "main.uneven": 4, "main.n": 2, "main.now": 3, "main.is_wet": 2,
        "main.name": 2, "main.wind": 5, "main.total": 3, "main.both": 6,
    }  # fmt: skip # outputs are not among them
    defined = covered_items(lower(load(tmp_path / "main.osc").checked, None))
    assert {each.item for each in defined} == {*counts, "main.steps", "main.calls"}


def test_constraints_that_exclude_a_bin_are_named(tmp_path: Path) -> None:
    space = inputs(tmp_path, GRID)
    (wanted,) = (each for each in space.bins if each.bucket == "8 x 2..3")
    with pytest.raises(Excluded) as caught:
        space.draw(wanted, 1)
    bounds, reason = caught.value.reasons
    assert bounds.startswith("keep(b in [0.0..10.0]) (") and bounds.endswith("main.osc:8:5)")
    assert reason.startswith("keep(a < 8 or b < 0.0) (") and reason.endswith("main.osc:9:5)")


def test_constraints_of_invoked_scenarios_exclude_bins(tmp_path: Path) -> None:
    space = inputs(tmp_path, INVOKING)
    excluded: dict[str, tuple[str, ...]] = {}
    for each in space.bins:
        try:
            space.draw(each, 1)
        except Excluded as error:
            excluded[each.bucket] = error.reasons
    assert list(excluded) == ["6"]
    (reason,) = excluded["6"]
    assert reason.startswith("keep(volume < 5) (") and reason.endswith("main.osc:5:5)")


INVOKED = """import osc.types
import osc.helpers

struct gust:
    wind: speed
    keep(default wind == 3mps)

scenario sail:
    pace: speed
    heel: float
    crew: int with:
        cover(crew, range: [0..4], every: 2)
    weather: gust
    cover(pace, unit: mps, range: [0..4], every: 1)
    cover(heel, range: [0..1], every: 0.5)
    cover(both, items: [pace, crew])
    cover(drift, expression: pace - weather.wind, unit: mps, buckets: [-5, 0, 5])
    cover(named, expression: crew == 1 and pace > 1mps)
    do wait elapsed(1s)

scenario rest:
    crew: int
    cover(crew, range: [0..4], every: 2)
    do wait elapsed(1s)

scenario main:
    knots: int
    keep(knots in [0..3])
    crew: int
    keep(crew in [0..3])
    keep(knots != 2)
    storm: gust
    keep(storm.wind in [0mps..4mps])
    do serial:
        sail(pace: 1mps * knots + 0.5mps, heel: 0.2, crew: crew, weather: storm)
        rest(crew)
        rest(1)
"""


def test_items_of_invoked_scenarios_are_reached_by_their_arguments(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    space = inputs(tmp_path, INVOKED)
    assert {each.item for each in space.bins} == {
        "sail.pace", "sail.heel", "sail.crew", "sail.both", "sail.drift", "sail.named", "rest.crew"
    }  # fmt: skip
    for number, each in enumerate(space.bins):
        if each.bucket.startswith("2..3") or (each.item, each.bucket) == ("sail.heel", "0.5..1"):
            with pytest.raises(Excluded):
                space.draw(each, number)
        else:
            assert (each.item, each.bucket) in space.draw(each, number).samples, each
    monkeypatch.chdir(tmp_path)
    assert run("out", "-j", "1") == 0
    assert main(["campaign", "coverage", "out"]) == 0
    shown = capsys.readouterr().out
    assert "sail.both: 6 of 6 buckets, 2 unreachable" in shown
    assert "keep(knots != 2)" in shown


VARYING = """import osc.types
import osc.helpers

scenario sail:
    pace: speed
    crew: int
    keep(pace < 2mps or crew > 1)
    cover(pace, unit: mps, range: [0..4], every: 1, event: start)
    cover(crew, range: [0..4], every: 2, event: start)
    cover(both, items: [pace, crew], event: start)
    do wait elapsed(1s)

scenario rest:
    crew: int
    cover(crew, range: [0..6], every: 2, event: start)
    do wait elapsed(1s)

scenario main:
    crew: int
    keep(crew in [0..3])
    do serial:
        trip: sail(crew: crew) with:
            keep(it.pace in [0mps..3mps])
        rest(crew)
        rest(5)
"""


def test_items_of_varying_parameters_and_of_several_invocations_are_reached(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    space = inputs(tmp_path, VARYING)
    excluded: dict[tuple[str, str], tuple[str, ...]] = {}
    for number, each in enumerate(space.bins):
        try:
            drawn = space.draw(each, number)
        except Excluded as error:
            excluded[each.item, each.bucket] = error.reasons
        else:
            assert (each.item, each.bucket) in drawn.samples, each
            assert drawn.values.keys() == {"crew", "trip.pace"}
    assert excluded.keys() == {("sail.both", "2..3 x 0..2"), ("sail.both", "3..4 x 0..2")}
    assert "keep(pace < 2mps or crew > 1)" in excluded["sail.both", "2..3 x 0..2"][-1]
    assert {each.bucket for each in space.bins if each.item == "rest.crew"} == {"0..2", "2..4", "4..6"}
    monkeypatch.chdir(tmp_path)
    assert run("out", "-j", "1") == 0
    assert main(["campaign", "coverage", "out"]) == 0
    shown = capsys.readouterr().out
    assert "coverage: 100 % of all reachable buckets" in shown
    assert "sail.both: 6 of 6 buckets, 2 unreachable" in shown


def test_an_invocation_elsewhere_makes_its_items_outputs(tmp_path: Path) -> None:
    hidden = "scenario inner:\n    do rest(2)\n\nscenario main"
    text = VARYING.replace("scenario main", hidden).replace("rest(5)", "inner()")
    assert {each.item for each in inputs(tmp_path, text).bins} == {"sail.pace", "sail.crew", "sail.both"}


def told(space: InputSpace, points: list[Point], *, is_sampled: bool = True) -> Iterator[Told]:
    """Yield results of runs whose items are sampled as expected."""
    for point in points:
        item, bucket = point.reason.split(" ", 1)
        plain = {"item": item, "kind": "cover", "buckets": {bucket: 1} if is_sampled else {}}
        yield Told(point, (Row(1, "", 1, 1, 1, End.PASSED, coverage=(plain,)),))


def test_bins_that_runs_do_not_reach_are_given_up(tmp_path: Path) -> None:
    space = inputs(tmp_path, KINDS)
    batches = Cover().batches(Space(inputs=space), 1)
    points, number = list(next(batches)), 0
    try:
        while True:
            number += len(points)
            points = list(batches.send(list(told(space, points, is_sampled=False))))
    except StopIteration:
        pass
    assert number <= 3 * len(space.bins)


def test_a_scenario_without_inputs_is_refused(tmp_path: Path) -> None:
    text = "import osc.helpers\nscenario main:\n    var n: int = 1\n    cover(n, range: [0..3])\n    do log('x')\n"
    with pytest.raises(UsageError, match="no `cover` item over its parameters"):
        Cover().batches(Space(inputs=inputs(tmp_path, text)), 1)


@pytest.fixture
def scenario(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(GRID)


def run(folder: str, *options: str) -> int:
    """Run a campaign."""
    clock = ("--clock", "virtual", "--seed", "1")
    return main(["campaign", "run", "main.osc", "--strategy", "cover", *clock, "-o", folder, *options])


@pytest.mark.usefixtures("scenario")
def test_directed_runs_fill_each_reachable_bucket_once(capsys: pytest.CaptureFixture[str]) -> None:
    assert run("out", "-j", "1") == 1
    assert len(table("out/runs.csv")) == 80, "80 of 100 combinations are reachable"
    capsys.readouterr()
    assert main(["campaign", "coverage", "out"]) == 0
    shown = capsys.readouterr().out
    assert "main.a: 8 of 8 buckets, 2 unreachable" in shown
    assert "main.both: 80 of 80 buckets, 20 unreachable" in shown
    assert "by keep(b in [0.0..10.0]) (main.osc:8:5) and keep(a < 8 or b < 0.0) (main.osc:9:5)" in shown
    assert "coverage: 100 % of all reachable buckets" in shown
    assert "  failed: " in shown and " of 8 runs in 9..10, the first is " in shown
    report = Path("out/report.html").read_text(encoding="utf-8")
    assert "100 % of all reachable buckets have enough samples" in report
    assert "Unreachable by keep(b in [0.0..10.0]) (main.osc:8:5) and keep(a &lt; 8" in report


@pytest.mark.usefixtures("scenario")
def test_a_campaign_ends_with_enough_coverage(capsys: pytest.CaptureFixture[str]) -> None:
    run("out", "-j", "1", "--until", "coverage 40%")
    assert "stopped: the coverage is " in capsys.readouterr().out
    assert main(["campaign", "coverage", "out", "out", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert 0.4 <= found["coverage"] < 1.0
    (a, _, both) = found["items"]
    assert (a["item"], a["reachable"], both["reachable"], both["total"]) == ("main.a", 8, 80, 100)
    assert all(bucket["samples"] == 2 for bucket in both["buckets"].values()), "each folder counts"


@pytest.mark.more
@pytest.mark.usefixtures("scenario")
def test_directed_runs_are_the_same_with_other_workers_and_after_an_interruption() -> None:
    run("one", "-j", "1")
    run("two", "-j", "2", "--runs", "70")
    main(["campaign", "resume", "two", "-j", "2", "--runs", "500"])
    one, two = (
        [{key: row[key] for key in row if key not in OF_THE_MACHINE} for row in table(f"{folder}/runs.csv")]
        for folder in ("one", "two")
    )
    assert one == two


@pytest.mark.usefixtures("scenario")
def test_items_that_are_defined_differently_are_not_merged(capsys: pytest.CaptureFixture[str]) -> None:
    run("one", "--runs", "1", "-j", "1")
    Path("main.osc").write_text(GRID.replace("every: 1", "every: 2"))
    run("two", "--runs", "1", "-j", "1")
    capsys.readouterr()
    assert main(["campaign", "coverage", "one", "two"]) == 2
    message = capsys.readouterr().err
    assert "the item `main.b` is defined differently in one and two: its buckets differ" in message


def test_counts_are_added_and_illegal_values_stay() -> None:
    merged = MergedCoverage()
    plain = {"item": "main.way", "kind": "cover", "unit": "m", "target": 2, "total": 4, "illegal": 1, "outside": 0}
    for number, (bucket, status) in enumerate([("0..1", End.PASSED), ("0..1", End.FAILED), ("3..4", End.FAILED)]):
        merged.add(Row(number + 7, "", 1, 1, 1, status, coverage=({**plain, "buckets": {bucket: 1}},)))
    (item,) = merged.items.values()
    first = item.buckets["0..1"]
    assert (first.samples, first.passed, first.failed, first.first) == (2, 1, 1, 7)
    assert (item.reached, item.illegal, merged.share) == (1, 3, 0.25)

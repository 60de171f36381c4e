"""Searches by Optuna and pyribs."""

from __future__ import annotations

import statistics
from collections.abc import Callable
from dataclasses import replace
from itertools import islice
from pathlib import Path
from typing import Any

import pytest

from seoro.campaign.runs import OF_THE_MACHINE, End, Point, Row
from seoro.campaign.space.axes import Choices
from seoro.campaign.space.space import Space
from seoro.campaign.store.covered import CoveredItem
from seoro.campaign.strategies.contract import Strategy, Told
from seoro.campaign.strategies.map_elites import MapElites
from seoro.campaign.strategies.optimizers import CmaEs, Tpe
from seoro.cli.main import main
from seoro.errors import UsageError
from tests.campaign.planted import COLUMN, in_one_place, results, runs_until_failure
from tests.campaign.spaces import SPAN, listed, ranged
from tests.campaign.test_campaigns import table

COLOURS = Choices("colour", tuple("abcdefgh"), None, SPAN)
MIXED = Space((COLOURS, listed("count", 6), ranged("size", 1.0, 3.0), ranged("number", 1, 9, is_whole=True)))


def evaluated(strategy: Strategy, space: Space, row_of: Callable[[Point], Row], batches: int) -> list[Told]:
    """The results of a strategy, in batches; impossible points have no runs."""
    generator = strategy.batches(space, 1)
    points, found = next(generator), []
    for _ in range(batches):
        told = [Told(each, (row_of(each),) if space.is_feasible(each.values) else ()) for each in points]
        found += told
        points = generator.send(told)
    return found


def row(status: End = End.PASSED, **fields: Any) -> Row:
    """A row of a run."""
    return Row(1, "", 1, 1, 1, status, **fields)


@pytest.mark.parametrize(
    ("strategy", "module", "most"), [(Tpe(COLUMN), "optuna", 45), (CmaEs(COLUMN), "cmaes", 60)]
)
def test_optimizers_need_few_runs_for_a_failure(strategy: Strategy, module: str, most: int) -> None:
    pytest.importorskip("optuna")
    pytest.importorskip(module)
    runs = [runs_until_failure(strategy, in_one_place(seed), seed, 400) for seed in range(7)]
    assert statistics.median(runs) <= most
    first, again, other = (
        [told.point for told in islice(results(strategy, in_one_place(3), seed), 40)] for seed in (1, 1, 2)
    )
    assert first == again != other, "they depend on the seed and the results only"


@pytest.mark.parametrize("strategy", [Tpe("m"), CmaEs("m"), Tpe(maximize="m", batch=3)])
def test_axes_of_all_kinds_vary_within_their_values(strategy: Strategy) -> None:
    pytest.importorskip("optuna")
    sign = -1 if isinstance(strategy, Tpe) and strategy.maximize else 1

    def evaluate(point: Point) -> Row:
        values = point.values
        distance = (values["colour"] != "c") + abs(float(values["size"]) - 2.5) + abs(int(values["number"]) - 7)
        return row(measured={"m": sign * distance})

    found = [told.point.values for told in evaluated(strategy, MIXED, evaluate, 12)]
    assert {each["colour"] for each in found} <= set("abcdefgh") and all(
        each["count"] in "012345" for each in found
    )
    assert all(1.0 <= float(each["size"]) <= 3.0 and 1 <= int(each["number"]) <= 9 for each in found)
    late = [abs(int(each["number"]) - 7) for each in found[len(found) // 2 :]]
    assert statistics.fmean(late) < 2.0, "about 2.7 at random"


def test_points_that_constraints_exclude_cost_no_run() -> None:
    pytest.importorskip("optuna")
    space = Space((ranged("a"), ranged("b")), is_feasible=lambda values: float(values["a"]) > 0.7)
    found = evaluated(Tpe("m"), space, lambda point: row(measured={"m": float(point.values["a"])}), 5)
    assert len(found) == 40 and all(told.rows for told in found)


def test_failures_and_errors_are_told_to_optimizers() -> None:
    pytest.importorskip("optuna")
    ends = {"a": End.FAILED, "b": End.ERROR}

    def evaluate(point: Point) -> Row:
        return row(ends.get(point.values["colour"], End.PASSED), margin=1.0)

    found = evaluated(Tpe(), Space((COLOURS,)), evaluate, 8)
    assert [told.point.values["colour"] for told in found[40:]].count("a") > 10, "3 of 24 at random"


@pytest.mark.parametrize(
    ("strategy", "space", "message"),
    [
        (Tpe(), Space(), "a search needs a parameter that varies"),
        (CmaEs(), Space((COLOURS,)), "the strategy `cmaes` needs a parameter with numbers"),
        (Tpe(batch=-1), MIXED, "expected at least 1 for `batch`, found -1"),
        (Tpe("a", "b"), MIXED, "`--minimize` contradicts `--maximize`"),
        (MapElites(cells="a,b,c"), MIXED, "expected a `cover` item, or two columns"),
        (MapElites(), MIXED, "the scenario has no `cover` item"),
        (MapElites(cells="main.b"), replace(MIXED, items=(CoveredItem(item="main.a", definition=""),)), "main.a"),
        (MapElites(), Space(), "a search needs a parameter that varies"),
    ],
)
def test_searches_that_cannot_begin_are_refused(
    strategy: Strategy, space: Space, message: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.campaign.strategies.optimizers.find_spec", lambda _: True)
    with pytest.raises(UsageError, match=message):
        strategy.batches(space, 1)


@pytest.mark.parametrize(("strategy", "module"), [(Tpe(), "optuna"), (CmaEs(), "cmaes"), (MapElites(), "ribs")])
def test_a_missing_package_is_named(strategy: Strategy, module: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(
        "seoro.campaign.strategies.optimizers.find_spec", lambda name: None if name == module else True
    )
    with pytest.raises(UsageError, match=f"needs {module}") as caught:
        strategy.batches(MIXED, 1)
    assert "pip install 'seoro[search]'" in str(caught.value.help)


def covered(point: Point) -> Row:
    """A run whose bucket is the place of `a`, and whose margin is the distance of `b` from it."""
    a, b = float(point.values["a"]), float(point.values["b"])
    items = (
        {"item": "main.a", "kind": "cover", "buckets": {f"{min(int(10 * a), 9)}": 1}},
        {"item": "x", "kind": "record"},
    )
    return row(margin=abs(a - b), coverage=items, measured={"robot.a": a, "robot.b": b})


@pytest.mark.slow
@pytest.mark.parametrize("cells", ["", "main.a", "robot.a,robot.b"])
def test_map_elites_finds_the_worst_run_of_each_cell(cells: str) -> None:
    pytest.importorskip("ribs")
    space = Space((ranged("a"), ranged("b")), items=(CoveredItem(item="main.a", definition=""),))
    first, again = (evaluated(MapElites(cells=cells), space, covered, 15) for _ in range(2))
    assert [told.point for told in first] == [told.point for told in again]
    worst: dict[int, float] = {}
    for told in first:
        cell, margin = min(int(10 * float(told.point.values["a"])), 9), told.rows[0].margin
        assert margin is not None
        worst[cell] = min(worst.get(cell, 1.0), margin)
    assert len(worst) == 10 and max(worst.values()) < 0.05


@pytest.mark.slow
def test_map_elites_needs_columns_with_numbers() -> None:
    pytest.importorskip("ribs")
    with pytest.raises(UsageError, match="no run has a number in the column `a`"):
        evaluated(MapElites(cells="a,b"), MIXED, lambda _: row(margin=1.0), 1)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["tpe", "cmaes", "map-elites"])
def test_learning_campaigns_are_continued(name: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text("""import osc.types
import osc.helpers
scenario main:
    a: float
    keep(a in [0.0..1.0])
    b: float
    keep(b in [0.0..1.0])
    cover(a, range: [0..1], every: 0.25)
    do serial:
        wait elapsed(1s)
        compare(a + b, ">", 0.3)
""")
    command = ["campaign", "run", "main.osc", "--strategy", name, "--clock", "virtual", "--seed", "5"]
    tables = []
    for folder, jobs, runs in (("one", "1", "50"), ("resumed", "2", "27")):
        main([*command, "-j", jobs, "--runs", runs, "-o", folder])
        if folder == "resumed":
            main(["campaign", "resume", folder, "--runs", "50", "-j", "2"])
        rows = table(f"{folder}/runs.csv")
        tables.append([{key: each[key] for key in each if key not in OF_THE_MACHINE} for each in rows])
    assert tables[0] == tables[1] and len(tables[0]) == 50
    assert "failed" in {each["status"] for each in tables[0]}

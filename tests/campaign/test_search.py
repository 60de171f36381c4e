"""Strategies that search for failures, or fill the space evenly."""

from __future__ import annotations

import statistics
import sys
from itertools import islice
from pathlib import Path

import pytest

from seoro.campaign.runs import OF_THE_MACHINE, End, Point, Row
from seoro.campaign.space.axes import Choices
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.contract import Told
from seoro.campaign.strategies.objective import Objective, objective_of
from seoro.campaign.strategies.random import Uniform
from seoro.campaign.strategies.search import BATCH, Search
from seoro.campaign.strategies.sobol import Sobol
from seoro.cli.main import main
from seoro.errors import UsageError
from tests.campaign.planted import COLUMN, in_four_places, in_one_place, results, runs_until_failure
from tests.campaign.spaces import SPAN, points, ranged
from tests.campaign.test_campaigns import table

TEXT = """import osc.types
import osc.helpers

scenario main:
    a: float with:
        keep(it in [0.0..1.0])
    b: float
    keep(b in [0.0..1.0])
    c: int
    keep(c in [1..4])
    keep(a < 0.95)
    do serial:
        wait elapsed(a * 1s + b * 1s)
        compare(a + b, ">", 0.3)
"""


def row(status: End = End.PASSED, margin: float | None = None, **measured: object) -> Row:
    """A row with measurements."""
    return Row(1, "", 1, 1, 1, status, margin=margin, measured=measured)


@pytest.mark.more
def test_a_search_needs_fewer_runs_than_random_draws() -> None:
    def median(strategy: Search | Uniform) -> float:
        return statistics.median(runs_until_failure(strategy, in_one_place(seed), seed, 400) for seed in range(40))

    assert median(Search(COLUMN)) <= 50
    assert median(Uniform()) >= 150


def test_a_search_finds_one_of_several_kinds_of_failures() -> None:
    runs = [
        [runs_until_failure(strategy, in_four_places(seed), seed, 400) for seed in range(40)]
        for strategy in (Search(COLUMN), Uniform())
    ]
    assert statistics.median(runs[0]) <= 0.75 * statistics.median(runs[1])


@pytest.mark.parametrize("batch", [1, 2, 40])
def test_a_search_has_batches_of_any_size(batch: int) -> None:
    batches = Search("m", batch=batch).batches(Space((ranged("a"),)), 1)
    drawn = next(batches)
    for number in range(4):
        drawn = batches.send([Told(each, (row(m=float(each.values["a"])),)) for each in drawn])
        assert len(drawn) == batch, number
    with pytest.raises(UsageError, match="expected at least 1 for `batch`"):
        Search("m", batch=0).batches(Space((ranged("a"),)), 1)


def test_a_search_continues_after_runs_without_a_verdict() -> None:
    batches = Search("m").batches(Space((ranged("a"),)), 1)
    drawn = next(batches)
    for _ in range(3):
        drawn = batches.send([Told(each, (row(End.ERROR),)) for each in drawn])
    assert len({each.values["a"] for each in drawn}) == BATCH


def test_a_search_stays_at_failures() -> None:
    found = list(islice(results(Search(COLUMN), in_one_place(3), 3), 400))
    failed = [told.rows[0].status is End.FAILED for told in found]
    assert sum(failed[200:]) > 100, "most runs of a search that has found failures fail"
    assert not all(failed[200:]), "and some explore"


def test_the_points_of_a_search_depend_on_the_seed_and_the_results_only() -> None:
    first, again, other = (
        [told.point for told in islice(results(Search(COLUMN), in_one_place(3), seed), 100)] for seed in (1, 1, 2)
    )
    assert first == again != other


def test_a_search_finds_the_best_of_values_without_order() -> None:
    axis = Choices("colour", tuple("abcdefghij"), None, SPAN)
    batches = Search("m").batches(Space((axis,)), 1)
    drawn = next(batches)
    for _ in range(5):
        drawn = batches.send([Told(each, (row(m=abs(ord(each.values["colour"]) - ord("g"))),)) for each in drawn])
    assert [each.values["colour"] for each in drawn].count("g") > BATCH / 2


def test_a_search_avoids_what_constraints_exclude() -> None:
    some = Space((ranged("a"),), is_feasible=lambda values: float(values["a"]) > 0.5)
    batches = Search("m").batches(some, 1)
    drawn = next(batches)
    for _ in range(3):
        told = [
            Told(each, (row(m=float(each.values["a"])),) if some.is_feasible(each.values) else ())
            for each in drawn
        ]
        drawn = batches.send(told)
        assert all(some.is_feasible(each.values) for each in drawn)


def test_objectives() -> None:
    point = Point({})
    margin, least = Objective("margin"), Objective("x")
    assert margin.value(Told(point, (row(margin=0.5), row(margin=0.2)))) == 0.2
    assert least.value(Told(point, (row(x=3), row(End.ERROR, x=1)))) == 3.0
    assert Objective("x", is_maximized=True).value(Told(point, (row(x=3), row(x=1)))) == -3.0
    assert margin.value(Told(point, (row(margin=0.5), row(End.FAILED)))) == float("-inf")
    assert margin.value(Told(point, (row(End.ERROR), row(), row(margin=float("nan"))))) is None
    assert margin.value(Told(point, ())) is None
    assert not least.is_known([Told(point, (row(End.FAILED),))])
    assert least.is_known([Told(point, (row(), row(x=1.0)))])
    with pytest.raises(UsageError, match="no run has a number in the column `clearanc`") as caught:
        Objective("clearanc").is_known([Told(point, (row(clearance=1.0, name="x"),))])
    assert "`clearance`" in str(caught.value.help)
    with pytest.raises(UsageError, match="no run has a margin") as caught:
        margin.is_known([Told(point, (row(clearance=1.0),))])
    assert "clearance, duration" in str(caught.value.help)


def test_a_search_lowers_the_margin_unless_another_column_is_named() -> None:
    assert objective_of("", "") == Objective("margin")
    assert objective_of("x", "") == Objective("x")
    assert objective_of("", "x") == Objective("x", is_maximized=True)
    with pytest.raises(UsageError, match="`--minimize` contradicts `--maximize`"):
        Search("x", "y").batches(Space((ranged("a"),)), 1)


def test_a_search_needs_a_parameter() -> None:
    with pytest.raises(UsageError, match="needs a parameter that varies"):
        Search().batches(Space(), 1)


def test_a_sobol_sequence_fills_the_space_evenly(monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip("scipy")
    some = Space((ranged("a"), ranged("b")))
    found = points(Sobol(), some, most=256)
    cells = {(int(float(each.values["a"]) * 16), int(float(each.values["b"]) * 16)) for each in found}
    assert len(cells) == 256, "each of 16 x 16 cells has one point"
    assert points(Sobol(), some, most=9) == found[:9] != points(Sobol(), some, seed=2, most=9)
    assert points(Sobol(), Space(), most=2) == [Point({}), Point({})]


def test_a_sobol_sequence_without_scipy_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "scipy.stats", None)
    with pytest.raises(UsageError, match="needs scipy") as caught:
        Sobol().batches(Space((ranged("a"),)), 1)
    assert "seoro[node]" in str(caught.value.help)


@pytest.mark.more
def test_a_search_has_the_same_runs_with_other_workers_and_after_an_interruption(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    command = ["campaign", "run", "main.osc", "--strategy", "search", "--clock", "virtual", "--seed", "5"]
    tables = []
    for folder, jobs, runs in (("one", "1", "45"), ("resumed", "2", "29")):
        main([*command, "-j", jobs, "--runs", runs, "-o", folder])
        if folder == "resumed":
            main(["campaign", "resume", folder, "--runs", "45", "-j", "2"])
        rows = table(f"{folder}/runs.csv")
        tables.append([{key: each[key] for key in each if key not in OF_THE_MACHINE} for each in rows])
    assert tables[0] == tables[1] and len(tables[0]) == 45
    assert "failed" in {each["status"] for each in tables[0][20:]}
    assert all((float(each["margin"]) < 0.0) == (each["status"] == "failed") for each in tables[0])
    assert main([*command, "--minimize", "clearance", "--runs", "30", "-o", "unknown", "-j", "1"]) == 2
    assert "no run has a number in the column `clearance`" in capsys.readouterr().err

"""Strategies that do not learn."""

from __future__ import annotations

import math
from collections.abc import Mapping
from itertools import combinations, product
from pathlib import Path
from random import Random

import pytest

from seoro.campaign.opening import space_of
from seoro.campaign.runs import Point
from seoro.campaign.space.axes import Choices
from seoro.campaign.space.space import Space
from seoro.campaign.store.folder import StrategyText
from seoro.campaign.strategies.boundary import Boundary
from seoro.campaign.strategies.choice import make_strategy, text_of
from seoro.campaign.strategies.latin import Latin
from seoro.campaign.strategies.pairwise import Pairwise
from seoro.campaign.strategies.permutation import Permutation
from seoro.cli.main import main
from seoro.embed import load
from seoro.embed.options import Options
from seoro.errors import UsageError
from tests.campaign.spaces import SPAN, listed, points, ranged

TEXT = """import osc.types
import osc.helpers

scenario main:
    noise: float = 0.2 with:
        keep(it in [0.0, 0.2, 0.4])
    way: length
    keep(way in [1m, 2m, 3m])
    keep(default way == 1m)
    load: float
    keep(load in [0.0..1.0])
    keep(noise < 0.3 or way == 1m)
    keep(load < 0.5 or way < 3m)
    keep(way < 3m or noise > 0.1)
    do log("run")
"""


def square(number: int, values: int) -> Space:
    """A space of listed values."""
    return Space(tuple(listed(f"p{axis}", values) for axis in range(number)))


def covered(found: list[Point], strength: int) -> set[tuple[tuple[str, str], ...]]:
    """All combinations of values of the points."""
    return {each for point in found for each in combinations(sorted(point.values.items()), strength)}


def space(folder: Path) -> Space:
    """The space of a scenario."""
    (folder / "main.osc").write_text(TEXT)
    return space_of(load(folder / "main.osc"), Options())


@pytest.mark.parametrize(
    ("number", "values", "strength", "most"), [(10, 4, 2, 31), (20, 5, 2, 59), (8, 3, 3, 60), (10, 4, 3, 161)]
)
def test_covering_arrays_are_complete_and_small(number: int, values: int, strength: int, most: int) -> None:
    found = points(Pairwise(strength), square(number, values))
    assert len(covered(found, strength)) == math.comb(number, strength) * values**strength
    assert len(found) <= most, "at most 1.1 times those of covertable 3.2"


def test_covering_arrays_are_the_same_for_a_seed() -> None:
    some = square(6, 3)
    assert points(Pairwise(), some, 1) == points(Pairwise(), some, 1) != points(Pairwise(), some, 2)


def test_parameters_of_a_covering_array_have_any_number_of_values() -> None:
    axes = (listed("a", 1), listed("b", 7), listed("c", 2), ranged("d"), listed("e", 3))
    found = points(Pairwise(levels=2), Space(axes))
    assert len(covered(found, 2)) == sum(x * y for x, y in combinations((1, 7, 2, 2, 3), 2))
    assert len(found) == 21, "the least possible"
    assert len(points(Pairwise(), Space((listed("a", 4),)))) == 4
    assert points(Pairwise(), Space()) == [Point({})]


def test_combinations_that_constraints_exclude_are_left_out() -> None:
    allowed = [
        {"p0": str(a), "p1": str(b), "p2": str(c)}
        for a, b, c in product(range(3), repeat=3)
        if (a or b < 2) and a + b + c < 4
    ]

    def is_feasible(values: Mapping[str, str]) -> bool:
        return any(all(values.get(path, text) == text for path, text in each.items()) for each in allowed)

    some = Space(square(6, 3).axes, is_feasible=is_feasible)
    for strength in (2, 3):
        found = points(Pairwise(strength), some)
        assert all(is_feasible(point.values) and len(point.values) == 6 for point in found)
        everything = covered(points(Pairwise(strength), square(6, 3)), strength)
        assert covered(found, strength) == {each for each in everything if is_feasible(dict(each))}


def test_a_parameter_without_an_allowed_value_in_a_row_is_left_to_the_run() -> None:
    """For example, a range whose levels are all excluded, but not the values between."""

    def is_feasible(values: Mapping[str, str]) -> bool:
        return values.get("a") != "1" or "c" not in values

    some = Space((listed("a", 2), listed("b", 2), listed("c", 2)), is_feasible=is_feasible)
    found = points(Pairwise(), some)
    assert {("a", "1"), ("b", "1")} in [set(each) for each in covered(found, 2)]
    assert all(is_feasible(point.values) for point in found)


def test_covering_arrays_respect_the_constraints_of_a_scenario(tmp_path: Path) -> None:
    found = points(Pairwise(), space(tmp_path))
    pairs = {(point.values["noise"], point.values["way"]) for point in found}
    assert pairs == {
        ("0.0", "1m"), ("0.2", "1m"), ("0.4", "1m"), ("0.0", "2m"), ("0.2", "2m"), ("0.2", "3m")
    }  # fmt: skip


@pytest.mark.parametrize(
    ("strategy", "some", "message"),
    [
        (Pairwise(), Space((ranged("a"), ranged("b"))), "of which the strategy `pairwise` has no values"),
        (Pairwise(1), square(3, 2), "expected a strength from 2, found 1"),
        (Pairwise(6), square(40, 9), "more than 500,000 combinations of 6 of 40 parameters"),
        (Latin(), square(3, 2), "needs its number of points"),
    ],
)
def test_unusable_strategies_are_refused_before_the_first_point(
    strategy: Pairwise | Latin, some: Space, message: str
) -> None:
    with pytest.raises(UsageError, match=message):
        strategy.batches(some, 1)


@pytest.mark.parametrize("size", [1, 2, 3, 64, 1000])
def test_permutations_have_each_number_once(size: int) -> None:
    permutation = Permutation(size, Random(1))
    assert sorted(map(permutation, range(size))) == list(range(size))
    assert size < 64 or permutation(0) != Permutation(size, Random(2))(0)


def test_each_part_of_a_range_has_one_point_of_a_latin_hypercube() -> None:
    some = Space((ranged("a"), ranged("b", 2.0, 4.0), listed("c", 5)))
    found = points(Latin(200), some, most=400)
    for first in (found[:200], found[200:]):
        assert sorted(int(float(point.values["a"]) * 200) for point in first) == list(range(200))
        assert sorted(int((float(point.values["b"]) - 2) * 100) for point in first) == list(range(200))
        assert all([point.values["c"] for point in first].count(text) == 40 for text in "01234")
    pairs = {(int(float(each.values["a"]) * 4), int(float(each.values["b"]) * 2)) for each in found}
    assert len(pairs) == 16, "axes are independent"


def test_a_large_latin_hypercube_begins_at_once() -> None:
    assert len(points(Latin(10**12), Space((ranged("a"),)), most=3)) == 3


def test_each_axis_is_at_its_boundaries_with_the_others_at_usual_values() -> None:
    paint = Choices("paint", ("red", "green"), None, SPAN)
    axes = (ranged("a", 0.0, 2.0), ranged("n", 1, 9, is_whole=True), listed("c", 7), paint)
    found = [tuple(point.values.values()) for point in points(Boundary(), Space(axes, {"c": "2"}))]
    assert found == [
        ("1.0", "5", "2", "red"),
        ("0.0", "5", "2", "red"), ("0.02", "5", "2", "red"), ("1.98", "5", "2", "red"), ("2.0", "5", "2", "red"),
        ("1.0", "1", "2", "red"), ("1.0", "2", "2", "red"), ("1.0", "8", "2", "red"), ("1.0", "9", "2", "red"),
        ("1.0", "5", "0", "red"), ("1.0", "5", "1", "red"), ("1.0", "5", "5", "red"), ("1.0", "5", "6", "red"),
        ("1.0", "5", "2", "green"),
    ]  # fmt: skip
    pairs = points(Boundary(True), Space(axes, {"c": "2"}))
    assert len(pairs) == 1 + 13 + 3 * 16 + 3 * 4, "`red` is usual"
    assert pairs[-1].reason == "c=6 paint=green"


def test_other_values_are_drawn_where_constraints_exclude_the_usual_ones(tmp_path: Path) -> None:
    some = space(tmp_path)
    assert dict(some.usual) == {"noise": "0.2", "way": "1m"}
    found = [dict(point.values) for point in points(Boundary(), some)]
    assert found[0] == {"noise": "0.2", "way": "1m", "load": "0.5"}
    assert {"noise": "0.4", "way": "1m", "load": "0.5"} in found
    assert {"way": "3m"} in found, "the usual load of 0.5 excludes it"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (StrategyText(name="pairwize", options={}), "unknown strategy `pairwize`"),
        (StrategyText(name="latin", options={"levels": 3}), "`--levels` has no effect with the strategy `latin`"),
        (StrategyText(name="grid", options={"levels": "3"}), "expected int for `levels`, found '3'"),
    ],
)
def test_unknown_strategies_and_options_are_refused(text: StrategyText, message: str) -> None:
    with pytest.raises(UsageError, match=message):
        make_strategy(text)
    assert make_strategy(text_of(Boundary(True))) == Boundary(True)


def test_strategies_are_chosen_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "main.osc").write_text(TEXT)
    command = ["campaign", "run", str(tmp_path / "main.osc"), "--clock", "virtual", "--seed", "5", "-j", "1"]
    command += ["--overwrite", "-o", str(tmp_path / "out")]
    assert main([*command, "--strategy", "pairwise", "--levels", "2"]) == 0
    assert main([*command, "--strategy", "latin", "--runs", "7"]) == 0
    assert "7 of 7 runs: 7 passed" in capsys.readouterr().out
    assert main([*command, "--strategy", "latin"]) == 2
    assert main([*command, "--pairs"]) == 2
    assert "`--pairs` has no effect with the strategy `grid`" in capsys.readouterr().err

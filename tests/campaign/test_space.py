"""Axes of a campaign."""

from pathlib import Path

import pytest

from seoro.campaign.space.axes import Axis, Choices, Interval
from seoro.campaign.space.finding import find_axes
from seoro.campaign.space.space import Space
from seoro.campaign.strategies.grid import Grid
from seoro.embed import Scenario, load
from seoro.errors import UsageError
from seoro.lang.frontend import lower

TEXT = """import osc.types
import osc.helpers

enum colour: [red, green]

struct limits:
    top: speed

scenario main:
    noise: float with:
        keep(it in [0, -0.2, 0.1 + 0.1])
    given: int = 3
    way: length
    keep(way in [1m..2m])
    count: int
    keep(count in [1..9])
    keep(count in [3..20])
    limit: limits with:
        keep(it.top in [1mps, 2mps])
    paint: colour
    keep(paint in [colour!red, colour!green])
    keep(paint in [colour!green])
    do log("run")
"""


def scenario(folder: Path, text: str = TEXT) -> Scenario:
    """Load a scenario file."""
    (folder / "main.osc").write_text(text)
    return load(folder / "main.osc")


def axes(folder: Path, *given: str, text: str = TEXT) -> dict[str, Axis]:
    """Return the axes, by path."""
    plan = lower(scenario(folder, text).checked, "main")
    return {axis.path: axis for axis in find_axes(plan, given)}


def choices(axis: Axis) -> tuple[str, ...]:
    """Return the values of an axis that lists them."""
    assert isinstance(axis, Choices)
    return axis.texts


def interval(axis: Axis) -> tuple[float, float, bool]:
    """Return the bounds of an axis, and whether its values are whole."""
    assert isinstance(axis, Interval)
    return axis.low, axis.high, axis.is_whole


def test_parameters_with_listed_values_or_bounds_vary(tmp_path: Path) -> None:
    found = axes(tmp_path)
    assert list(found) == ["noise", "way", "count", "limit.top", "paint"]
    assert choices(found["noise"]) == ("0", "-0.2", "0.1 + 0.1")
    assert interval(found["way"]) == (1.0, 2.0, False)
    assert interval(found["count"]) == (3, 9, True), "the constraints of a parameter are intersected"
    assert choices(found["limit.top"]) == ("1mps", "2mps")
    assert choices(found["paint"]) == ("colour!green",)


def test_given_parameters_do_not_vary(tmp_path: Path) -> None:
    assert list(axes(tmp_path, "noise", "limit", "way", "count")) == ["paint"]


def test_parameters_of_invocations_vary_by_label_or_name(tmp_path: Path) -> None:
    text = """import osc.types
import osc.helpers

scenario greet:
    name: string
    do log(name)

scenario main:
    do parallel:
        greet() with:
            keep(it.name in ["a", "b"])
        serial:
            greet("x")
            last: greet() with:
                keep(it.name in ["c", "d"])
            log() with:
                keep(it.msg in ["1", "2"])
"""
    found = axes(tmp_path, "log", text=text)
    assert {path: choices(axis) for path, axis in found.items()} == {
        "greet[0].name": ('"a"', '"b"'),
        "last.name": ('"c"', '"d"'),
    }


def test_bounds_that_depend_on_other_parameters_are_no_axis(tmp_path: Path) -> None:
    text = """import osc.helpers
scenario main:
    least: float = 1.0
    noise: float
    keep(noise in [least..2.0])
    do log("run")
"""
    assert not axes(tmp_path, text=text)


def test_constraints_that_leave_no_value_are_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="the constraints of `count` leave no value"):
        axes(tmp_path, text=TEXT.replace("[3..20]", "[10..20]"))


def test_values_of_a_range_are_written_in_the_unit_of_the_parameter(tmp_path: Path) -> None:
    found = axes(tmp_path)
    way, count = found["way"], found["count"]
    assert isinstance(way, Interval) and isinstance(count, Interval)
    assert [way.at(share) for share in (0.0, 0.25)] == ["1.0m", "1.25m"]
    assert tuple(way.levels(3)) == ("1.0m", "1.5m", "2.0m")
    assert [count.at(share) for share in (0.0, 0.5, 0.999999)] == ["3", "6", "9"]
    assert tuple(count.levels(100)) == ("3", "4", "5", "6", "7", "8", "9")
    assert tuple(count.levels(2)) == ("3", "9")


def test_values_of_a_range_are_made_on_demand(tmp_path: Path) -> None:
    found = axes(tmp_path)
    way = found["way"]
    assert isinstance(way, Interval)
    levels = way.levels(10**12)
    assert len(levels) == 10**12 and levels[0] == "1.0m" and levels[-1] == "2.0m"
    batches = Grid(levels=10**12).batches(Space((way, found["count"])), 0)
    assert batches is not None and next(batches)[0].values == {"way": "1.0m", "count": "3"}

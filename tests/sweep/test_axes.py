"""Axes of a sweep."""

from pathlib import Path

import pytest

from seoro.embed import Scenario, load
from seoro.errors import UsageError
from seoro.lang.frontend import lower
from seoro.sweep.axes import Axis, combinations, find_axes
from seoro.sweep.emit import emitted

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


def axes(folder: Path, *given: str) -> dict[str, tuple[str, ...]]:
    """Return the values of the axes, by path."""
    plan = lower(scenario(folder).checked, "main")
    return {axis.path: axis.values for axis in find_axes(plan, given)}


def test_parameters_with_a_list_of_values_vary(tmp_path: Path) -> None:
    assert axes(tmp_path) == {
        "noise": ("0", "-0.2", "0.1 + 0.1"),
        "limit.top": ("1mps", "2mps"),
        "paint": ("colour!green",),
    }


def test_given_parameters_do_not_vary(tmp_path: Path) -> None:
    assert list(axes(tmp_path, "noise", "limit")) == ["paint"]


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
    plan = lower(scenario(tmp_path, text).checked, "main", {"greet[1].name": "'x'"})
    assert {axis.path: axis.values for axis in find_axes(plan, ["log"])} == {
        "greet[0].name": ('"a"', '"b"'),
        "last.name": ('"c"', '"d"'),
    }


def test_the_last_axis_varies_fastest(tmp_path: Path) -> None:
    span = lower(scenario(tmp_path).checked, "main").scenarios["main"].span
    two = [Axis("a", ("1", "2"), span), Axis("b", ("x", "y"), span)]
    assert [tuple(each.values()) for each in combinations(two)] == [("1", "x"), ("1", "y"), ("2", "x"), ("2", "y")]


def test_too_many_combinations_are_refused(tmp_path: Path) -> None:
    span = lower(scenario(tmp_path).checked, "main").scenarios["main"].span
    many = [Axis(f"p{number}", tuple(map(str, range(100))), span) for number in range(3)]
    with pytest.raises(UsageError, match="too many combinations: 1,000,000"):
        next(combinations(many))


def test_a_combination_is_a_file_that_runs_elsewhere(tmp_path: Path) -> None:
    (tmp_path / "lib").mkdir()
    (tmp_path / "lib" / "thing.osc").write_text("import osc.types\nstruct thing:\n    size: length = 1m\n")
    swept = scenario(tmp_path, 'import "lib/thing.osc"\n' + TEXT)
    folder = tmp_path / "deep" / "inside"
    folder.mkdir(parents=True)
    varying = find_axes(lower(swept.checked, "main"), ["paint"])
    text = emitted(swept, varying, {"noise": "-0.2", "limit.top": "1mps"}, folder)
    assert text.startswith('import "../../lib/thing.osc"\n')
    assert "keep(it in [-0.2])" in text
    assert "keep(it.top in [1mps])" in text
    assert "keep(paint in [colour!red, colour!green])" in text
    (folder / "one.osc").write_text(text)
    assert not load(folder / "one.osc").checked.errors

"""Values that overrides settle: the same as those of the solver, and only where nothing is open."""

from __future__ import annotations

import random
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

from seoro.embed import load
from seoro.errors import InvalidScenario
from seoro.lang.frontend import lower as lower_checked
from seoro.runtime.choose import choose as choosing
from seoro.runtime.choose import settled
from seoro.runtime.parameters.parameters import entry_parameters
from seoro.runtime.values.environment import EvaluationError, NoSolution
from seoro.runtime.values.values import Value
from tests.lang.helpers import lower

DECLARED = """import osc.types

enum paint: [red, green, blue]
struct place:
    x: length = 2m
    y: length = 3m

actor robot:
    speed: speed = 1mps
    label: string = 'r'

global shared: int with:
    keep(it in [1, 2, 3])

scenario main:
"""

SETTLED = [
    ("x: int with:\n keep(it in [1, 2, 3])", {"x": "2"}),
    ("x: uint with:\n keep(it in [0..9])", {"x": "0"}),
    ("x: float\nkeep(x in [0.0..1.0])", {"x": "1.0"}),
    ("x: float\nkeep(x in [0.0..1.0])", {"x": "1"}),
    ("x: length\nkeep(x in [10cm..2m])", {"x": "100cm"}),
    ("x: uint\nkeep(x >= 0)", {"x": "3 - 2"}),
    ("x: bool\ny: bool\nkeep(x or y)", {"x": "true", "y": "false"}),
    ("x: paint\nkeep(x in [paint!red, paint!blue])", {"x": "paint!blue"}),
    ("x: string\nkeep(x in ['a', 'b'])", {"x": "'b'"}),
    ("x: int = 4\nkeep(default x == 5)\nkeep(x < 9)", {"x": "7"}),
    ("x: time\ny: float\nkeep(y < 0.5 or x < 4s)\nkeep(x in [1s, 2s, 4s])", {"x": "2s", "y": "0.75"}),
    ("x: int\nkeep(x in [1, 2])\ny: int = x + 1\nvar z: int = y\np: place\nr: robot", {"x": "2"}),
    ("x: int\ny: int = 3\nkeep(x in [1, 2])\nr: robot", {"x": "2"}),
    ("x: int\nkeep(x * x == 4)", {"x": "-2"}),
    ("x: int\nkeep(x in [1, 2])", {"x": "1", "shared": "3"}),
]

OPEN = [
    ("x: int with:\n keep(it in [1, 2, 3])", {"x": "4"}),  # broken
    ("x: int\ny: int\nkeep(x in [1, 2])\nkeep(y in [x..5])", {"x": "2"}),
    ("x: int\ny: int = 3\nkeep(x < y)", {"x": "2"}),
    ("x: int\nkeep(x in [1, 2])\ny: int = 3\nkeep(default y == x)", {"x": "2"}),
    ("p: place\nkeep(p.x in [1m, 2m])", {"p.x": "2m"}),
    ("x: int\nkeep(x in [1, 2])\ny: int = 1", {"x": "y"}),
    ("x: int\nkeep(x in [1, 2])\ny: int\nkeep(y == 1)", {"x": "1"}),
    ("x: int\nkeep(x in [1, 2])\nkeep(it.duration < 5s)", {"x": "1"}),
    ("x: list of int\nkeep(x.size() == 1)", {"x": "[3]"}),
]


BOUNDED = [  # with constraints from outside
    ("x: int", {"x": "2"}, ("x in [1..3]",), True),
    ("x: int", {"x": "5"}, ("x in [1..3]",), False),
    ("x: int", {"x": "2"}, ("x == 3",), False),
    ("x: int\ny: int = 4", {"x": "2"}, ("x < y",), False),
]


def _chosen(folder: Path, members: str, overrides: Mapping[str, str], seed: int) -> list[tuple[str, Value, type]]:
    lines = "".join(f"    {line}\n" for line in members.split("\n"))
    overrides = {"shared": "2", **overrides}
    values = entry_parameters(lower(folder, DECLARED + lines, overrides, "main"), seed)
    return [(name, value, type(value)) for name, value in values.items()]


def _by_solver(folder: Path, members: str, overrides: Mapping[str, str], seed: int) -> object:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(settled, "settle", lambda *_: False)
        return _outcome(folder, members, overrides, seed)


def _outcome(folder: Path, members: str, overrides: Mapping[str, str], seed: int) -> object:
    try:
        return repr(_chosen(folder, members, overrides, seed))
    except InvalidScenario as error:
        return str(error)
    except NoSolution as error:
        return str(error), error.code, [(span.text, note) for span, note in error.places]
    except EvaluationError as error:
        return str(error)


@pytest.mark.parametrize(("members", "overrides"), SETTLED)
def test_settled_values_equal_those_of_the_solver(
    tmp_path: Path, members: str, overrides: Mapping[str, str], monkeypatch: pytest.MonkeyPatch
) -> None:
    by_solver = _by_solver(tmp_path, members, overrides, 0)
    monkeypatch.setattr(choosing, "choose", None)  # not needed
    assert _outcome(tmp_path, members, overrides, 0) == by_solver


@pytest.mark.parametrize(("members", "overrides"), OPEN)
def test_the_solver_decides_what_is_open(tmp_path: Path, members: str, overrides: Mapping[str, str]) -> None:
    tried: list[bool] = []
    settle = settled.settle

    def noted(*given: Any) -> bool:
        tried.append(settle(*given))
        return tried[-1]

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(settled, "settle", noted)
        outcome = _outcome(tmp_path, members, overrides, 7)
    assert outcome == _by_solver(tmp_path, members, overrides, 7)
    assert not any(tried)


def test_random_values_are_judged_as_by_the_solver(tmp_path: Path) -> None:
    members = "a: int\nb: int\nkeep(a in [0..4] and b in [0..4])\nkeep(a + b != 4)\nkeep(a > 1 or b < 3)"
    draws = random.Random(1)
    for _ in range(30):
        overrides = {"a": str(draws.randint(-1, 5)), "b": str(draws.randint(-1, 5))}
        assert _outcome(tmp_path, members, overrides, 3) == _by_solver(tmp_path, members, overrides, 3)


@pytest.mark.parametrize(("members", "overrides", "constraints", "is_settled"), BOUNDED)
def test_constraints_from_outside_must_hold(
    tmp_path: Path, members: str, overrides: Mapping[str, str], constraints: tuple[str, ...], is_settled: bool
) -> None:
    lines = "".join(f"    {line}\n" for line in members.split("\n"))
    file = tmp_path / "test.osc"
    file.write_text(DECLARED + lines)
    plan = lower_checked(load(file).checked, "main", {"shared": "2", **overrides}, constraints)
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(choosing, "choose", None)
        if is_settled:
            assert entry_parameters(plan, 0)["x"] == 2
        else:
            with pytest.raises(TypeError):  # the solver is asked
                entry_parameters(plan, 0)

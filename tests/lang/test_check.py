"""Checking beyond the golden messages: traits, strictness, and limits."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.lang import frontend
from seoro.lang.symbols import Kind
from seoro.lang.traits import ParameterTrait
from tests.lang.helpers import check, messages


def test_parameters_of_any_type_take_any_argument(tmp_path: Path) -> None:
    path = tmp_path / "test.osc"
    path.write_text("import osc.helpers\nscenario main:\n    do log(3m)\n", encoding="utf-8")
    sources = frontend.load(path)
    assert [found.code for found in frontend.check(sources).diagnostics] == ["E0301"]
    traits = {(Kind.ACTION, "log"): {"msg": ParameterTrait.ANY}}
    assert frontend.check(sources, traits).diagnostics == ()
    strict = frontend.check(sources, traits, strict=True)
    assert [found.code for found in strict.diagnostics] == ["E0392", "E0393"]
    assert strict.errors == ()


@pytest.mark.parametrize(
    ("argument", "code"),
    [("n", None), ("c.trips", None), ("m", "E0444"), ("n + 1", "E0444"), ("s", "E0301"), ("gone", "E0216")],
)
def test_actions_that_change_variables_accept_paths_of_variables_only(
    argument: str, code: str | None, tmp_path: Path
) -> None:
    text = "import osc.helpers\nactor cart:\n    var trips: int\nscenario main:\n    var n: int\n    m: int = 1\n"
    text += f"    var s: string\n    c: cart\n    do increment({argument})\n"
    path = tmp_path / "test.osc"
    path.write_text(text, encoding="utf-8")
    traits = {(Kind.ACTION, "increment"): {"target_variable": ParameterTrait.NUMBER}}
    found = [diagnostic.code for diagnostic in frontend.check(frontend.load(path), traits).diagnostics]
    assert found == ([code] if code else [])


def test_strict_checks_warn_of_extensions(tmp_path: Path) -> None:
    text = "import osc.types\nscenario main:\n    x: length = 5\n    p: position_3d = position_3d(x: 1m)\n"
    assert messages(tmp_path, text) == []
    assert messages(tmp_path, text, strict=True) == [(1, "E0392"), (3, "E0390"), (4, "E0391")]


def test_scenarios_of_the_entry_file_are_listed(tmp_path: Path) -> None:
    (tmp_path / "a.osc").write_text("scenario a\n", encoding="utf-8")
    text = 'import "a.osc"\nactor c\nscenario b\nscenario c.d\n'
    assert check(tmp_path, text).scenarios == ("b", "c.d")


def test_long_chains_and_deep_blocks_are_checked(tmp_path: Path) -> None:
    chain = " + ".join(["1"] * 400)
    assert messages(tmp_path, f"struct a:\n    x: int = {chain}\n") == []
    depth = 100
    lines = [f"{'  ' * (level + 2)}serial:" for level in range(depth)]
    text = "\n".join(["scenario main:", "  do serial:", *lines, "  " * (depth + 2) + "emit end", ""])
    assert messages(tmp_path, text) == []


@pytest.mark.parametrize(
    "expression", ["(" * 300 + "1" + ")" * 300, "not " * 5000 + "true", "-" * 3000 + "x", "[" * 500]
)
def test_endless_nesting_of_expressions_is_an_error(expression: str, tmp_path: Path) -> None:
    found = messages(tmp_path, f"struct a:\n    x: int = {expression}\n")
    assert all(code in {"E0133", "E0301", "E0112", "E0120"} for _, code in found)


def test_endless_nesting_of_blocks_is_an_error(tmp_path: Path) -> None:
    lines = [f"{' ' * (level + 2)}serial:" for level in range(1000)]
    text = "\n".join(["scenario main:", " do serial:", *lines, " " * 1002 + "emit end", ""])
    assert [code for _, code in messages(tmp_path, text)] == ["E0133"]


@pytest.mark.parametrize("default", ["s()", "s(b: 1)", "t()"])
def test_a_default_that_constructs_its_own_type_is_reported(default: str, tmp_path: Path) -> None:
    text = f"struct s:\n  a: s = {default}\n  b: int = 2\nstruct t:\n  c: s = s()\n"
    assert (1, "E0426") in messages(tmp_path, text)


def test_a_variable_as_a_type_condition_is_an_error(tmp_path: Path) -> None:
    text = "struct s:\n  var n: bool = true\nstruct t inherits s(n == true)\n"
    assert messages(tmp_path, text) == [(3, "E0298")]

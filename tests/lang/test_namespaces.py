"""Namespaces, extensions and name resolution (7.7, 7.3.9), beyond the golden messages."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.errors import InvalidScenario
from seoro.lang import plan
from seoro.runtime.parameters.parameters import entry_parameters
from tests.lang.helpers import check, lower, messages

EXPORTS = """
namespace depot
export crate, width
struct crate:
    width: int = 4
    depth: int = 5

namespace garage
struct van

namespace shop use depot
export crate, depot::width, garage::*
"""


@pytest.mark.parametrize(
    ("statement", "member", "code"),
    [
        ("namespace a use depot", "c: crate", None),
        ("namespace a use depot", "c: van", "E0211"),
        ("namespace a use shop", "c: van", None),
        ("namespace a use shop", "c: list of crate", None),
        ("namespace a", "c: shop::crate", None),
        ("namespace a", "c: crate", "E0211"),
        ("namespace null", "c: |depot|::crate", None),
        ("namespace a use shop", "c: int = depot::crate().width", None),
        ("namespace a use shop", "c: int = crate().depth", "E0215"),
        ("namespace a use shop", "c: int = crate().depot::depth", None),
        ("namespace a use depot, shop", "c: crate", None),
    ],
)
def test_exported_names_are_accessible(statement: str, member: str, code: str | None, tmp_path: Path) -> None:
    found = messages(tmp_path, f"{EXPORTS}\n{statement}\nstruct s:\n    {member}\n")
    assert [each for _, each in found] == ([code] if code else [])


def test_a_member_of_another_namespace_is_suggested_with_its_prefix(tmp_path: Path) -> None:
    text = f"{EXPORTS}\nnamespace null\nstruct s:\n    c: depot::crate\n    d: int = c.width\n    e: crate\n"
    helps = {found.help for found in check(tmp_path, text).diagnostics}
    assert helps == {"did you mean `depot::width`?", "did you mean `depot::crate`?"}


def test_an_empty_namespace_can_be_used(tmp_path: Path) -> None:
    text = "namespace depot\nnamespace shop use depot\nnamespace yard use dept\nstruct crate\n"
    assert messages(tmp_path, text) == [(3, "E0222")]


def test_a_global_parameter_precedes_the_struct_of_its_name(tmp_path: Path) -> None:
    declarations = "struct scale:\n    base: int = 1\n    def weight() -> int is expression base\n"
    uses = "global scale: scale with:\n    keep(it.base == 5)\nscenario main:\n    n: int = scale.weight()\n"
    assert messages(tmp_path, declarations + uses, strict=True) == []
    assert entry_parameters(lower(tmp_path, declarations + uses), 0)["n"] == 5


def test_names_in_the_plan_are_unique(tmp_path: Path) -> None:
    declarations = "struct crate\nnamespace depot\nstruct crate inherits ::crate\n"
    made = lower(tmp_path, f"{declarations}scenario main:\n    a: crate\n    b: null::crate\n")
    assert made.entry == "depot::main"
    a, b = made.scenarios[made.entry].structure.fields.values()
    assert a.type == plan.StructType("depot::crate", ("crate",), ())
    assert b.type == plan.StructType("crate", (), ())


def test_a_scenario_is_found_without_its_namespace(tmp_path: Path) -> None:
    text = "namespace a\nscenario main\nscenario x\nnamespace b\nscenario x\n"
    assert lower(tmp_path, text).entry == "a::main"
    assert lower(tmp_path, text, scenario="b::x").entry == "b::x"
    with pytest.raises(InvalidScenario, match="a::x"):
        lower(tmp_path, text, scenario="x")


def test_extensions_of_another_namespace_keep_their_own_names(tmp_path: Path) -> None:
    text = """
namespace depot
struct crate:
    width: int = 1

namespace shop use depot
extend depot::crate:
    width: int = depot::width + 1
    def both() -> int is expression width + depot::width
"""
    assert messages(tmp_path, text) == []


def test_an_extension_may_add_the_behavior_of_a_scenario(tmp_path: Path) -> None:
    made = lower(tmp_path, "extend main:\n    event go\n    do emit go\nscenario main\n")
    assert isinstance(made.scenarios["main"].body, plan.Emit)


@pytest.mark.parametrize(
    ("text", "line", "code"),
    [
        ("struct a:\n    n: int\nextend a:\n    n: int\n", 4, "E0210"),
        ("enum e: [a]\nextend e:\n    n: int\n", 2, "E0212"),
        ("struct e\nextend e: [a]\n", 2, "E0212"),
        ("scenario a:\n    do emit end\nextend a:\n    do emit end\n", 4, "E0413"),
        ("actor a\nextend a.turn:\n    n: int\n", 2, "E0401"),
        ("global a: int = b\nglobal b: int = a\n", 1, "E0219"),
        ("struct a:\n    n: int = f()\n    def f() -> int is expression n\n", 2, "E0219"),
        ("global a: int = 1\nglobal a: int = 2\n", 2, "E0210"),
        ("global a: int = 1.5\n", 1, "E0301"),
        ("extend int:\n    def f() -> int is expression it\n    def f() -> int is expression 2\n", 3, "E0340"),
        ("struct a:\n    def f(n: int) -> int is expression n\n    x: int = f([1..2])\n", 3, "E0301"),
    ],
)
def test_wrong_declarations_are_reported_at_their_line(text: str, line: int, code: str, tmp_path: Path) -> None:
    assert (line, code) in messages(tmp_path, text)


def test_a_global_parameter_needs_a_value_to_run(tmp_path: Path) -> None:
    text = "global limit: int\nscenario main\n"
    assert messages(tmp_path, text) == []
    with pytest.raises(InvalidScenario, match="global parameter `limit` has no value"):
        lower(tmp_path, text)

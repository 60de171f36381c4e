"""Expressions of scenarios and their values, methods and globals included."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

import pytest

from seoro.embed import load
from seoro.lang.frontend import lower
from seoro.runtime.parameters.parameters import entry_parameters
from seoro.runtime.values.environment import EvaluationError
from seoro.runtime.values.values import Value
from tests.runtime.conftest import RunText

HEADER = "import osc.types\n"


def fields(folder: Path, text: str, scenario: str | None = None) -> Mapping[str, Value]:
    """Return the values of the parameters of the entry scenario."""
    path = folder / "test.osc"
    path.write_text(HEADER + text)
    plan = lower(load(path).checked, scenario)
    return entry_parameters(plan, seed=0)


def value(folder: Path, type_: str, expression: str, declarations: str = "") -> Value:
    """Return the value of an expression in a scenario."""
    return fields(folder, f"{declarations}\nscenario main:\n    x: {type_} = {expression}\n")["x"]


@pytest.mark.parametrize(
    ("type_", "expression", "expected"),
    [
        ("uint", "[4, 5].size()", 2),
        ("list of int", "[5, 2, 9].filter(it > 3)", (5, 9)),
        ("list of int", "[1, 2].map(it * [1, 2, 3].count(it > 1))", (2, 4)),
        ("list of float", "[[1, 2], 3, [4.5]]", (1.0, 2.0, 3.0, 4.5)),
        ("int", "[5, 9, 9].first_index(it == 9)", 1),
        ("int", "[5].first_index(it == 9)", -1),
        ("bool", "[5].has(it == 5) and not [5].has(it == 6)", True),
        ("bool", "[1..2] in [2..1] and not ([1..3] in [1..2])", True),
        ("length", "[3m .. 20cm].lower()", 0.2),
        ("float", "range(1, 2.5).upper()", 2.5),
        ("string", '"Hello".substring(-3, end: 99)', "llo"),
        ("list of string", '",a,".split(",")', ("", "a", "")),
        ("string", '"-".join(["a", "b"]).replace("a", "c").trim()', "c-b"),
        ("int", "(-7.9).as(int)", -7),
        ("list of int", "[1.5, -2.5].as(list of int)", (1, -2)),
        ("length", "position_3d(x: 3m, y: 4m, z: 12m).norm()", 13.0),
        ("speed", "translational_velocity_3d(x: 3mps, y: 4mps).norm()", 5.0),
    ],
)
def test_operators_of_lists_ranges_and_strings(
    type_: str, expression: str, expected: Value, tmp_path: Path
) -> None:
    assert value(tmp_path, type_, expression) == expected


@pytest.mark.parametrize(
    ("type_", "expression", "expected"),
    [
        ("int", " - ".join(["1"] * 5000), -4998),
        ("string", " + ".join(["'a'"] * 5000), "a" * 5000),
        ("bool", " and ".join(["true"] * 5000) + " and false", False),
        ("bool", " == ".join(["false"] * 5001), False),
    ],
    ids=["sum", "text", "and", "equal"],
)
def test_long_chains_of_operators_are_evaluated(
    type_: str, expression: str, expected: Value, tmp_path: Path
) -> None:
    assert value(tmp_path, type_, expression) == expected


@pytest.mark.parametrize(
    ("type_", "expression", "message"),
    [
        ("rgb", "7.as(rgb)", "`rgb` has no member with the number 7"),
        ("uint", "(-1).as(uint)", "-1 does not fit into `uint`"),
        ("int", "nan.as(int)", "cannot convert nan to `int`"),
        ("derived", "box.as(derived)", "expected `derived`, found `crate`"),
        ("list of string", '"a".split("")', "empty separator in `split`"),
        ("int", "endless(1)", "nested more than 64 deep"),
        ("int", "missing()", "method `missing` is undefined"),
        ("int", "eager().early", "the value of `early` depends on itself"),
    ],
)
def test_an_expression_without_a_value_is_an_error_with_its_position(
    type_: str, expression: str, message: str, tmp_path: Path
) -> None:
    text = f"""
enum rgb: [red, green]
struct crate
struct derived inherits crate
struct eager:
    early: int = read(it)
    late: int = early
    def read(other: eager) -> int is expression other.late
scenario main:
    box: crate
    def endless(n: int) -> int is expression endless(n + 1)
    def missing() -> int is undefined
    x: {type_} = {expression}
"""
    with pytest.raises(EvaluationError, match=message) as caught:
        fields(tmp_path, text)
    assert caught.value.span.text in {expression, "endless(n + 1)", "early"}


# ---------------------------------------------------------------- methods


METHODS = """
struct tag:
    n: int = 3
    def value(by: int = n) -> int is expression n * by
    def twice() -> int is expression 2 * value()

struct red_tag inherits tag:
    def value(by: int) -> int is only expression 100 + by

extend tag:
    def value(by: int) -> int is only expression 10 + by

extend int:
    def doubled() -> int is expression it + it

extend string:
    def shout(mark: string = "!") -> string is expression it + mark
"""


@pytest.mark.parametrize(
    ("type_", "expression", "expected"),
    [
        ("int", "tag().value()", 13),
        ("int", "tag().twice()", 26),
        ("int", "red_tag(n: 4).twice()", 208),
        ("int", "tag(n: 2).value(by: 5)", 15),
        ("list of int", "[tag(), red_tag()].map(it.value(1))", (11, 101)),
        ("int", "3.doubled().doubled()", 12),
        ("string", '"a".shout().shout("?")', "a!?"),
    ],
)
def test_the_value_decides_which_method_is_called(
    type_: str, expression: str, expected: Value, tmp_path: Path
) -> None:
    assert value(tmp_path, type_, expression, METHODS) == expected


def test_fields_have_their_values_before_methods_read_them(tmp_path: Path) -> None:
    found = fields(
        tmp_path,
        """
struct crate:
    a: int = doubled() + 1
    b: int = 4
    def doubled() -> int is expression it.b * 2

scenario main:
    y: int = total()
    c: crate
    z: int = 3
    def total() -> int is expression z + c.a
""",
    )
    assert found["y"] == 12


def test_methods_of_the_running_scenario_are_called(tmp_path: Path) -> None:
    text = """
scenario base:
    def word() -> string is expression "base"
    x: string = word()

scenario main inherits base:
    def word() -> string is only expression "main"
"""
    assert fields(tmp_path, text, "base")["x"] == "base"
    assert fields(tmp_path, text, "main")["x"] == "main"


@pytest.mark.parametrize(
    ("declaration", "message"),
    [
        ("int is external os.getcwd()", "`os.getcwd` returned a value of str; expected `int`"),
        ("float is external math.sqrt(-1)", "`math.sqrt` failed: ValueError: math domain error"),
        ("int is external time.sleep(0)", "`time.sleep` returned nothing; expected `int`"),
        ("uint is external operator.neg(1)", "expected `uint`"),
    ],
)
def test_failed_external_methods_are_errors_with_their_name(
    declaration: str, message: str, tmp_path: Path
) -> None:
    with pytest.raises(EvaluationError, match=message):
        fields(tmp_path, f"scenario main:\n    def f() -> {declaration}\n    x: float = f()\n")


def test_external_methods_receive_named_arguments_and_return_declared_types(tmp_path: Path) -> None:
    text = """
scenario main:
    def matches(name: string, pat: string) -> bool is external fnmatch.fnmatch()
    def rounded(number: float) -> float is external builtins.round(ndigits: 1)
    def parts(sep: string) -> list of string is external builtins.str.split("a-b")
    x: bool = matches("front_camera", pat: "front_*")
    y: float = rounded(2.26)
    z: list of string = parts("-")
"""
    found = fields(tmp_path, text)
    assert (found["x"], found["y"], found["z"]) == (True, 2.3, ("a", "b"))


# ---------------------------------------------------------------- namespaces, globals, conditions


def test_fields_hide_global_parameters(tmp_path: Path) -> None:
    text = """
global twice: int = 2 * once
global once: int = 4

struct crate:
    n: int = once + 1

scenario main:
    once: int = 1
    c: crate
    x: list of int = [twice, once, c.n]
"""
    assert fields(tmp_path, text)["x"] == (8, 1, 5)


def test_fields_of_one_name_in_two_types_are_separate(tmp_path: Path) -> None:
    text = """
namespace depot

struct crate:
    width: int = 4
    def area() -> int is expression width * width

namespace null

struct big_crate inherits depot::crate:
    width: int = 7

scenario main:
    c: big_crate
    x: list of int = [c.width, c.depot::width, c.depot::area()]
"""
    assert fields(tmp_path, text)["x"] == (7, 4, 16)


CONDITIONS = """
enum cargo_kind: [liquid, people]

struct vessel:
    cargo: cargo_kind
    armed: bool = false
    def label() -> string is expression "vessel"

struct tanker inherits vessel(cargo == liquid):
    tanks: int = 7
    def label() -> string is only expression "tanker"

struct fire_boat inherits tanker(armed == true):
    hoses: int = tanks + 1

struct warship inherits vessel(armed == true)
"""


@pytest.mark.parametrize(
    ("type_", "expression", "expected"),
    [
        ("bool", "vessel(cargo: liquid).is(tanker)", True),
        ("bool", "vessel(cargo: people).is(tanker)", False),
        ("bool", "vessel(cargo: liquid).is(fire_boat)", False),
        ("int", "vessel(cargo: liquid, armed: true).as(fire_boat).hoses", 8),
        ("bool", "tanker(armed: true).is(warship)", True),
        ("bool", "tanker().cargo == liquid", True),
        ("string", "vessel(cargo: liquid).label()", "tanker"),
        ("string", "vessel(cargo: people).label()", "vessel"),
    ],
)
def test_the_field_of_a_condition_determines_the_type(
    type_: str, expression: str, expected: Value, tmp_path: Path
) -> None:
    assert value(tmp_path, type_, expression, CONDITIONS) == expected


@pytest.mark.parametrize(
    ("subtypes", "expression", "message"),
    [
        ("struct red inherits tag(on == true):\n    n: int\n", "tag(on: true)", "`x.n` has no value"),
        (
            "struct a inherits tag(on == true):\n    n: int = 1\n"
            "struct b inherits tag(up == true):\n    n: int = 2\n",
            "tag(on: true, up: true)",
            "of two conditional types that both have a field `n`",
        ),
        ("struct red inherits tag(on == true)\n", "red(on: 1 > 2)", "cannot hold"),
    ],
)
def test_impossible_conditional_types_are_errors(
    subtypes: str, expression: str, message: str, tmp_path: Path
) -> None:
    declarations = f"struct tag:\n    on: bool = false\n    up: bool = false\n{subtypes}"
    with pytest.raises(EvaluationError, match=message):
        value(tmp_path, "tag", expression, declarations)


async def test_behaviors_use_methods_and_global_parameters(run_text: RunText) -> None:
    ran = await run_text("""
global greeting: string = "hello"
global driver: courier

actor courier:
    name: string = "anna"
    def words(to: string) -> string is expression greeting + " " + to + " from " + name

scenario courier.greet:
    do log(actor.words("you"))

scenario main:
    c: courier
    def at_all() -> bool is expression c == driver
    do serial:
        c.greet()
        driver.greet()
        log(at_all() ? "same" : "two")
""")
    assert [text for _, text in ran.logs] == ["hello you from anna", "hello you from anna", "two"]
    assert ran.verdict.passed
    assert list(ran.records[0]["parameters"]) == ["global null::greeting", "global null::driver", "c"]

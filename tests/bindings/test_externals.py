"""External methods (7.3.7.4), bound to Python functions when a scenario is loaded."""

from pathlib import Path

import pytest

from seoro.embed import prepare
from seoro.embed.options import Options
from tests.bindings.conftest import Check

PYTHON = """
from __future__ import annotations
import enum
from dataclasses import dataclass
from typing import TYPE_CHECKING, Sequence
from pydantic import BaseModel
from seoro import EnumValue, MethodContext, Position3D, Range, Struct
if TYPE_CHECKING:
    from nowhere import Anything

def both(a: float, b: float) -> str: return f"a={a} b={b}"
def swapped(b: float, a: float) -> str: return f"a={a} b={b}"
def first(x: str, a: float, /, b: float = 0.0) -> str: return f"x={x} a={a} b={b}"
def keyword(x: str, *, a: float, b: float, c: int = 0) -> str: return f"x={x} a={a} b={b} c={c}"
def rest(*numbers: float) -> float: return sum(numbers)
def named(**numbers: float) -> str: return str(sorted(numbers))
def seeded(run: MethodContext, a: float) -> float: return a + run.seed
def lazy(a: Anything) -> float: return 2 * a
def count(a: int) -> float: return a
def numbers(a: Sequence[float]) -> list[float]: return [x * 2 for x in a]
def fixed(a: tuple[float, float]) -> float: return a[0]
def middle(a: Range) -> float: return (a.low + a.high) / 2
def widened(a: Range) -> Range: return Range(a.low - 1, a.high + 1)
def many() -> list[str]: return ["a", 1]
async def slow(a: float) -> float: return a
def none() -> list[Crate]: return []
def nothing(a: float) -> None: ...
def sets(a: float) -> set[float]: return {a}
def pair(a: Position3D) -> Position3D: return Position3D(a.y, a.x, a.z)

class Colour(enum.Enum):
    red = "r"
    green = "g"
def other(c: Colour) -> Colour: return Colour.green if c is Colour.red else Colour.red
class Size(enum.Enum):
    small = 1
def wrong_enum(c: Size) -> bool: return True
def same(c: EnumValue) -> EnumValue: return c

class Crate(BaseModel):
    name: str
    at: Position3D
    inner: list["Crate"]
def names(crate: Crate) -> str: return crate.name + "".join(names(part) for part in crate.inner)
def packed(crate: Struct) -> Crate:
    return Crate(name="outer", at=Position3D(1.0), inner=[Crate(name="in", at=Position3D(), inner=[])])
class Box(BaseModel):
    name: int
    at: Position3D
    inner: list["Box"]
def boxed(crate: Box) -> str: return ""
class Holder:
    @staticmethod
    def held(a: float) -> float: return a + 1
value = 3
def fails(a: float) -> float: raise ValueError("two\\nlines")
"""

HEADER = """import osc.types
import osc.helpers
enum colour: [red, green]
struct crate:
    name: string
    at: position_3d
    inner: list of crate
"""


def files(declaration: str, expression: str = "") -> dict[str, str]:
    body = f"        log({expression})\n" if expression else "        emit end\n"
    none = "    def none() -> list of crate is external checks.none()\n"
    main = f"{HEADER}scenario main:\n    def f{declaration}\n{none}    do serial:\n{body}"
    return {"main.osc": main, "checks.py": PYTHON}


@pytest.mark.parametrize(
    ("declaration", "expression", "expected"),
    [
        ("(a: float, b: float) -> string is external checks.both()", "f(1.0, 2.0)", "a=1.0 b=2.0"),
        ("(a: float, b: float) -> string is external checks.swapped()", "f(1.0, b: 2.0)", "a=1.0 b=2.0"),
        ("(a: float, b: float) -> string is external checks.both(b: a + 1.0)", "f(1.0, 9.0)", "a=1.0 b=2.0"),
        ("(b: float) -> string is external checks.first('x', 2.0)", "f(3.0)", "x=x a=2.0 b=3.0"),
        ("(p: string, q: float) -> string is external checks.first()", "f('y', 3.0)", "x=y a=3.0 b=0.0"),
        (
            "(a: float, b: float) -> string is external checks.keyword('z', c: 4)",
            "f(1.0, 2.0)",
            "x=z a=1.0 b=2.0 c=4",
        ),
        ("(a: float, b: float) -> float is external checks.rest(10.0)", "f(1.0, 2.0)", "13.0"),
        ("(p: float, q: float) -> string is external checks.named(r: 1.0)", "f(1.0, 2.0)", "['p', 'q', 'r']"),
        ("(a: float) -> float is external checks.seeded()", "f(0.5)", "7.5"),
        ("(a: float) -> float is external checks.lazy()", "f(2.0)", "4.0"),
        ("(a: int) -> float is external checks.count()", "f(3)", "3.0"),
        ("(a: int) -> float is external checks.seeded()", "f(3)", "10.0"),
        ("(a: length) -> length is external checks.Holder.held()", "f(3m) / 1m", "4.0"),
        ("(a: list of float) -> list of float is external checks.numbers()", "f([1.0, 2.0])[1]", "4.0"),
        ("(a: range of float) -> float is external checks.middle()", "f([1.0..3.0])", "2.0"),
        ("(a: range of float) -> range of float is external checks.widened()", "f([1.0..3.0]).upper()", "4.0"),
        ("(a: position_3d) -> position_3d is external checks.pair()", "f(position_3d(x: 2m)).y / 1m", "2.0"),
        ("(c: colour) -> colour is external checks.other()", "f(colour!red) == colour!green ? 'g' : 'r'", "g"),
        ("(c: colour) -> colour is external checks.same()", "f(colour!red) == colour!red ? 'r' : 'g'", "r"),
        (
            "(crate: crate) -> string is external checks.names()",
            "f(crate('a', position_3d(), [crate('b', position_3d(), none())]))",
            "ab",
        ),
        (
            "(crate: crate) -> crate is external checks.packed()",
            "f(crate('a', position_3d(), none())).inner[0].name",
            "in",
        ),
        ("(x: float) -> float is external math.sqrt()", "f(4.0)", "2.0"),
        ("(s: string) -> string is external html.escape()", "f('<')", "&lt;"),
        ("(l: list of float) -> float is external builtins.max()", "f([1.0, 3.0])", "3.0"),
    ],
)
async def test_arguments_and_results_are_converted(
    declaration: str, expression: str, expected: str, check_files: Check
) -> None:
    scenario = check_files(files(declaration, expression))
    assert [found.message for found in scenario.checked.diagnostics] == []
    async with prepare(scenario, Options(clock="virtual", seed=7)) as run, run.running():
        assert [record["message"] async for record in run.trace() if record["kind"] == "log"] == [expected]


@pytest.mark.parametrize(
    ("declaration", "code", "message"),
    [
        ("(a: float) -> float is external no_such.f()", "E0606", "Python module `no_such` of"),
        ("(a: float) -> float is external checks.boths()", "E0607", "`checks` has no `boths`"),
        ("(a: float) -> float is external checks.Holder.hold()", "E0607", "`checks.Holder` has no `hold`"),
        ("(a: float) -> float is external checks.value()", "E0609", "it is not a function"),
        ("(a: float) -> float is external checks.slow()", "E0609", "it is asynchronous, but methods take no time"),
        ("(a: float) -> float is external asyncio.sleep()", "E0609", "it is asynchronous"),
        (
            "(a: float) -> string is external checks.both()",
            "E0609",
            "it takes (a, b), and is given (a: ...)",
        ),
        (
            "(a: float, c: float) -> string is external checks.both()",
            "E0609",
            "it takes (a, b), and is given (a: ..., c: ...)",
        ),
        (
            "(a: float, b: float) -> string is external checks.both('x')",
            "E0609",
            "it takes (a, b), and is given ('x', a: ..., b: ...)",
        ),
        ("(x: float, y: float) -> float is external math.sqrt()", "E0609", "it takes (x), and is given (x, y)"),
        ("(a: string) -> float is external checks.rest()", "E0609", "it takes `float` where `a` gives `str`"),
        (
            "(a: float) -> float is external checks.seeded(a: 'x')",
            "E0609",
            "it takes `float` where `a` gives `str`",
        ),
        ("(a: float) -> float is external checks.count()", "E0609", "it takes `int` where `a` gives `float`"),
        ("(a: float) -> string is external checks.seeded()", "E0609", "it returns `float`, not `str`"),
        ("(a: float) -> float is external checks.nothing()", "E0609", "it returns `None`, not `float`"),
        ("(a: float) -> list of float is external checks.sets()", "E0609", "it returns `set[float]`, not"),
        (
            "(a: list of float) -> float is external checks.fixed()",
            "E0609",
            "it takes `tuple[float, float]` where",
        ),
        ("(c: colour) -> bool is external checks.wrong_enum()", "E0609", "it takes `Size` where `c` gives"),
        (
            "(crate: crate) -> string is external checks.boxed()",
            "E0609",
            "it takes `Box` where `crate` gives `Struct`",
        ),
    ],
)
def test_a_signature_mismatch_is_reported_at_the_declaration(
    declaration: str, code: str, message: str, check_files: Check
) -> None:
    [found] = check_files(files(declaration)).checked.diagnostics
    assert (found.code, found.primary.span.line) == (code, 9)
    assert found.primary.span.text.startswith("external ")
    assert message in found.message


def test_a_module_that_raises_is_a_message_with_its_line(check_files: Check) -> None:
    made = files("() -> int is external broken.f()") | {"broken.py": "\n1 / 0\n"}
    [found] = check_files(made).checked.diagnostics
    assert found.code == "E0608"
    assert found.message.endswith(": ZeroDivisionError: division by zero (broken.py, line 2)")


def test_a_method_without_result_may_call_a_function_with_one(check_files: Check) -> None:
    assert check_files(files("(a: float) is external checks.lazy()")).checked.diagnostics == ()


@pytest.mark.parametrize(
    ("declaration", "expression", "reason"),
    [
        (
            "(a: float) -> float is external checks.fails()",
            "f(1.0)",
            "`checks.fails` failed: ValueError: two lines",
        ),
        (
            "() -> list of string is external checks.many()",
            "f()[0]",
            "`checks.many` returned a value of list; expected",
        ),
        ("(a: float) -> float is external checks.lazy()", "f(inf) > 0.0 ? 'x' : 'y'", ""),
    ],
)
async def test_failures_in_a_run_are_reported_at_the_call(
    declaration: str, expression: str, reason: str, check_files: Check
) -> None:
    scenario = check_files(files(declaration, expression))
    assert scenario.checked.diagnostics == ()
    async with prepare(scenario, Options(clock="virtual")) as run, run.running():
        verdict = await run.result()
    assert verdict.passed == (reason == "")
    assert reason in verdict.reason


async def test_modules_beside_the_file_go_before_installed_ones(check_files: Check) -> None:
    made = files("() -> string is external platform.node()", "f()") | {
        "platform.py": "def node(): return 'mine'\n"
    }
    async with prepare(check_files(made), Options(clock="virtual")) as run, run.running():
        assert [record["message"] async for record in run.trace() if record["kind"] == "log"] == ["mine"]


def test_a_library_finds_its_neighbours(check_files: Check) -> None:
    made = {
        "main.osc": "import osc.garden\n",
        "seoro.libraries/garden.osc": "struct a:\n    def f() -> int is external garden.f()\n"
        "    def g() -> int is external tools.g()\n",
        "seoro.libraries/garden.py": "def f() -> int: return 1\n",
        "seoro.libraries/tools.py": "def g() -> int: return 1\n",
    }
    assert check_files(made).checked.diagnostics == ()


def test_methods_of_an_imported_file_find_modules_beside_it(check_files: Check, tmp_path: Path) -> None:
    made = {
        "main.osc": 'import "parts/part.osc"\n',
        "parts/part.osc": "struct a:\n    def f() -> int is external near.f()\n",
        "parts/near.py": "def f() -> int: return 1\n",
    }
    assert check_files(made).checked.diagnostics == ()

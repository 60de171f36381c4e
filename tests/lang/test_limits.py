"""Endless texts: each quickly gives a message or a plan, with little memory and no deep recursion."""

from __future__ import annotations

import time
from collections.abc import Callable
from pathlib import Path

import pytest

from seoro.errors import InvalidScenario
from seoro.lang import frontend
from seoro.lang.diagnostic import MAX_ERRORS as MAX_MESSAGES
from seoro.lang.diagnostic import MAX_TEXT
from seoro.lang.lexer import MAX_ERRORS
from seoro.lang.render import MAX_WIDTH, render_text
from tests.lang.helpers import check, lower, messages
from tests.sampling import sampled

LEVELS = 1000
TERMS = 10_000
LONG = 1_000_000  # characters
DO = "  do serial:\n    wait elapsed(1s)\n"


def of_type(type_: str, value: str) -> str:
    """Return a scenario with a parameter."""
    return f"import osc.types\nscenario main:\n  y: {type_} = {value}\n{DO}"


def blocks(levels: int, word: str, inner: str) -> str:
    """Return nested compositions."""
    lines = [f"{' ' * (level + 4)}{word}:\n" for level in range(levels)]
    return f"import osc.types\nscenario main:\n  do serial:\n{''.join(lines)}{' ' * (levels + 4)}{inner}\n"


def nested(levels: int) -> dict[str, str]:
    """Return texts with nesting of each kind."""
    return {
        "lists": of_type("bool", f"{'[' * levels}1{']' * levels} == 1"),
        "minus": of_type("int", f"{'- ' * levels}1"),
        "not": of_type("bool", f"{'not ' * levels}true"),
        "ternary in the middle": of_type("int", f"{'true ? ' * levels}1{' : 1' * levels}"),
        "fields": of_type("int", f"a{'.b' * levels}"),
        "calls": of_type("int", f"{'f(' * levels}1{')' * levels}"),
        "calls in a row": of_type("int", f"f{'()' * levels}"),
        "elements": of_type("int", f"a{'[0]' * levels}"),
        "casts": of_type("int", f"1{'.as(int)' * levels}"),
        "operators in turn": of_type("bool", f"{'(' * levels}true{' and true) == true' * levels}"),
        "types": of_type(f"{'list of ' * levels}int", "1"),
        "serial": blocks(levels, "serial", "wait elapsed(1s)"),
        "parallel": blocks(levels, "parallel", "wait elapsed(1s)"),
        "bases": "struct s0\n" + "".join(f"struct s{n + 1} inherits s{n}\n" for n in range(levels)),
        "structs": "struct s0\n" + "".join(f"struct s{n + 1}:\n  a: s{n}\n" for n in range(levels)),
    }


@pytest.mark.parametrize("kind", nested(0))
def test_endless_nesting_is_one_error(kind: str, tmp_path: Path) -> None:
    found = {code for _, code in messages(tmp_path, nested(LEVELS)[kind])}
    assert found == {"E0133"}


@pytest.mark.parametrize(
    ("levels", "text"),
    [
        (500, lambda n: blocks(n, "serial", "wait elapsed(1s)")),
        (110, lambda n: of_type("int", f"{'- ' * n}1")),
        (110, lambda n: of_type("int", f"{'true ? ' * n}1{' : 1' * n}")),
        (5_000, lambda n: of_type("int", f"{'true ? 1 : ' * n}1")),
        (110, lambda n: blocks(500, "parallel", f"wait elapsed({'true ? ' * n}1s{' : 1s' * n})")),
        (
            80,
            lambda n: of_type("int", f"{'a.f(' * n}1{')' * n}").replace(
                "scenario main:\n", "struct t:\n  def f(x: int) -> int is expression x\nscenario main:\n  a: t\n"
            ),
        ),
    ],
    ids=["blocks", "minus", "ternary", "table", "ternary in blocks", "calls"],
)
def test_nesting_within_the_limit_is_lowered(levels: int, text: Callable[[int], str], tmp_path: Path) -> None:
    assert lower(tmp_path, text(levels)).entry == "main"


def test_redundant_brackets_may_be_nested(tmp_path: Path) -> None:
    assert lower(tmp_path, of_type("int", f"{'(' * LEVELS}1{')' * LEVELS}")).entry == "main"


@pytest.mark.parametrize(
    ("type_", "operator", "operand"),
    [
        ("int", "+", "1"),
        ("bool", "and", "true"),
        *(
            pytest.param(*chain, marks=pytest.mark.more)
            for chain in (
                ("int", "*", "1"),
                ("string", "+", "'a'"),
                ("bool", "or", "true"),
                ("bool", "=>", "true"),
                ("bool", "==", "true"),
                ("length", "-", "1m"),
            )
        ),
    ],
)
def test_chains_of_operators_may_be_long(type_: str, operator: str, operand: str, tmp_path: Path) -> None:
    chain = f" {operator} ".join([operand] * TERMS)
    assert lower(tmp_path, of_type(type_, chain)).entry == "main"


ENDLESS = {
    "string": (of_type("string", f'"{"a" * LONG}"'), None),
    "escapes": (of_type("string", '"' + "\\n" * (LONG // 2) + '"'), None),
    "comment": (of_type("int", f"1  # {'c' * LONG}"), None),
    "name": (of_type("int", "1").replace("y:", "y" * LONG + ":"), None),
    "unknown name": (of_type("int", "y" * LONG), "E0216"),
    "unclosed string": (of_type("string", '"' + "a" * LONG), "E0111"),
    "unclosed long string": (of_type("string", '"""' + "a" * LONG), "E0111"),
    "digits": (of_type("int", "1" * LONG), "E0130"),
    "unit": (of_type("length", "1" + "m" * LONG), "E0213"),
    "list": (of_type("list of int", f"[{','.join(['1'] * (LONG // 2))}]"), "E0101"),
    "sum": (of_type("int", "+".join(["1"] * (LONG // 2))), "E0101"),
    "signs": (of_type("int", "-" * LONG + "1"), "E0101"),
    "brackets": ("(" * LONG, "E0101"),
    "module": (f"import {'a.' * (LONG // 2)}a\n", "E0101"),
    "path": (f'import "{"a/" * (LONG // 2)}"\n', "E0202"),
    "no characters of the language": ("$" * LONG, "E0110"),
    "zero bytes": ("\0" * LONG, "E0110"),
    "bars": ("|" * LONG, "E0138"),
    "blanks": (" " * LONG + "x", "E0114"),
    "tabs": ("\t" * LONG + "x", "E0114"),
}


@pytest.mark.parametrize("kind", ENDLESS)
def test_a_line_of_a_megabyte_is_checked_quickly(kind: str, tmp_path: Path) -> None:
    text, code = ENDLESS[kind]
    start = time.process_time()
    checked = check(tmp_path, text)
    shown = [render_text(found) for found in checked.diagnostics]
    if code is None:
        assert frontend.lower(checked).entry == "main"
    assert time.process_time() - start < 2.0
    assert {found.code for found in checked.diagnostics} == ({code} if code else set())
    assert len(shown) <= MAX_ERRORS
    assert all(len(each) < 2 * MAX_TEXT + 3 * MAX_WIDTH for each in shown)


def test_the_number_of_reported_missing_imports_is_limited(tmp_path: Path) -> None:
    text = "".join(f"import osc.none{number}\n" for number in range(1000))
    assert len(check(tmp_path, text).diagnostics) == 30


def test_an_override_has_the_same_limits(tmp_path: Path) -> None:
    with pytest.raises(InvalidScenario, match="nested too deeply"):
        lower(tmp_path, of_type("int", "1"), {"y": f"{'- ' * LEVELS}1"})


@pytest.mark.parametrize("value", sampled(["", " = 1", " = m{before}", " = m0", " = m{after}"], every=2))
def test_an_enumeration_may_be_long(value: str, tmp_path: Path) -> None:
    values = [value.format(before=n - 1, after=n + 1) if 0 < n < TERMS - 1 else "" for n in range(TERMS)]
    members = ", ".join(f"m{number}{text}" for number, text in enumerate(values))
    start = time.process_time()
    checked = check(tmp_path, f"enum e: [{members}]\nscenario main:\n  x: e = m0\n  do serial:\n    emit end\n")
    assert not checked.diagnostics
    assert time.process_time() - start < 2.0


def test_many_mutual_exports_of_namespaces_are_checked_quickly(tmp_path: Path) -> None:
    first = "".join(f"namespace {name}0\nexport {name}\nstruct {name}\n" for name in ("a", "b"))
    layers = (
        f"namespace {name}{n + 1} use a{n}, b{n}\nexport a, b\n" for n in range(LEVELS // 4) for name in "ab"
    )
    last = f"namespace null use a{LEVELS // 4}\nscenario main:\n  x: a\n{DO}"
    start = time.process_time()
    assert lower(tmp_path, f"import osc.types\n{first}{''.join(layers)}{last}")
    assert time.process_time() - start < 2.0


def test_many_errors_are_found_quickly_and_limited(tmp_path: Path) -> None:
    text = of_type("list of int", f"[{', '.join(f'z{number}' for number in range(TERMS))}]")
    start = time.process_time()
    assert len(check(tmp_path, text).diagnostics) == MAX_MESSAGES
    assert time.process_time() - start < 2.0

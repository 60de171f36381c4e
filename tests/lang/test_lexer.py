"""The lexical layer (7.2.1)."""

from __future__ import annotations

import pytest

from seoro.lang import ast
from seoro.lang.diagnostic import Bag
from seoro.lang.escapes import unescape, unknown_escapes
from seoro.lang.lexer import Lexer
from seoro.lang.source import SourceFile
from tests.lang.helpers import expression, parse


def kinds(text: str) -> list[str]:
    return [token.kind for token in Lexer(SourceFile("test.osc", text), Bag()).tokens()]


@pytest.mark.parametrize("end", ["\n", "\r", "\r\n"])
def test_every_line_end_ends_a_line(end: str) -> None:
    tree, codes = parse(f"struct a:{end}    x: int{end}{end}struct b{end}")
    assert codes == []
    assert len(tree.statements) == 2


@pytest.mark.parametrize("tail", ["", "\n", "   ", "\n\n   \t", "\n    # comment", "\n\f\n", " \\\n"])
def test_a_file_may_end_in_any_blanks(tail: str) -> None:
    tree, codes = parse("struct a:\n    x: int" + tail)
    assert codes == []
    assert isinstance(tree.statements[0], ast.StructDeclaration)


def test_tabs_indent_to_multiples_of_eight() -> None:
    _, codes = parse("struct a:\n\tx: int\n        y: int\n    \tz: int\n")
    assert codes == []


def test_comments_may_have_any_indentation() -> None:
    _, codes = parse("struct a:\n# left\n    x: int\n            # deep\n  # between\n    y: int # behind\n")
    assert codes == []


def test_lines_are_joined_in_brackets_and_by_backslashes() -> None:
    _, codes = parse("struct a:\n    x: list of int = [1,\n2, # two\n\n  3]\n    y: int = 1 + \\\n2\n")
    assert codes == []


def test_form_feeds_do_not_indent() -> None:
    _, codes = parse("struct a:\n\f    x: int\n\f\n    y: int\n")
    assert codes == []


def test_blocks_are_closed_at_the_end() -> None:
    assert kinds("struct a:\n  x: int")[-3:] == ["_NEWLINE", "_DEDENT", "$END"]


def test_names_in_bars_may_contain_any_character() -> None:
    tree = expression("|gap (m)|+|do|")
    assert isinstance(tree, ast.Arithmetic)
    assert isinstance(tree.left, ast.NameExpression)
    assert tree.left.name.text == "gap (m)"


@pytest.mark.parametrize("name", ["größe", "名前", "_x2", "a‿b", "\u2167", "naïve"])
def test_names_may_have_letters_of_any_script(name: str) -> None:
    tree = expression(name)
    assert isinstance(tree, ast.NameExpression)
    assert tree.name.text == name


@pytest.mark.parametrize("name", ["‿a", "½", "a°"])
def test_invalid_characters_of_names_are_reported(name: str) -> None:
    assert "E0110" in parse(f"struct a:\n    {name}: int\n")[1]


@pytest.mark.parametrize(
    ("text", "value"),
    [("5", 5), ("0x1F", 31), ("-5", -5), ("18446744073709551615", 2**64 - 1), ("-9223372036854775808", -(2**63))],
)
def test_integers_are_read(text: str, value: int) -> None:
    tree = expression(text)
    assert isinstance(tree, ast.IntegerLiteral)
    assert tree.value == value


@pytest.mark.parametrize(
    ("text", "value"),
    [(".5", 0.5), ("1e6", 1e6), ("42.0E4", 42e4), ("+1.5", 1.5), ("-2.5e-1", -0.25), ("+inf", 1e999)],
)
def test_floats_are_read(text: str, value: float) -> None:
    tree = expression(text)
    assert isinstance(tree, ast.FloatLiteral)
    assert tree.value == value


@pytest.mark.parametrize(
    ("text", "value", "unit"),
    [
        ("3m", 3, "m"),
        ("-1.5mps", -1.5, "mps"),
        ("15|foot/s|", 15, "foot/s"),
        ("0x10m", 16, "m"),
        ("1e3m", 1000.0, "m"),
    ],
)
def test_physical_literals_are_read(text: str, value: float, unit: str) -> None:
    tree = expression(text)
    assert isinstance(tree, ast.PhysicalLiteral)
    assert (tree.value, tree.unit.text) == (value, unit)


def test_a_prefixed_unit_belongs_to_its_number() -> None:
    tree = expression("3stdtypes::m")
    assert isinstance(tree, ast.PhysicalLiteral)
    assert (tree.unit.namespace, tree.unit.text) == ("stdtypes", "m")


def test_a_minus_after_an_operand_subtracts() -> None:
    tree = expression("a -5")
    assert isinstance(tree, ast.Arithmetic)
    assert isinstance(tree.right, ast.IntegerLiteral)
    assert tree.right.value == 5


def test_two_dots_make_a_range_and_one_a_fraction() -> None:
    tree = expression("[0...5]")
    assert isinstance(tree, ast.RangeConstructor)
    assert isinstance(tree.high, ast.FloatLiteral)
    assert isinstance(expression("[1..5]"), ast.RangeConstructor)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        (r'"a \"b\" \\ \n"', 'a "b" \\ \n'),
        (r"'it\'s \d'", r"it's \d"),
        ('"""two\nlines "quoted" """', 'two\nlines "quoted" '),
        ("''", ""),
        ('""""a" """', '"a" '),
    ],
)
def test_strings_are_read(text: str, value: str) -> None:
    tree = expression(text)
    assert isinstance(tree, ast.StringLiteral)
    assert tree.value == value


@pytest.mark.parametrize(
    ("written", "meant"),
    [(r"\u00e9", "é"), (r"\x41", "A"), (r"\U0001F600", "\U0001f600"), (r"\a", "\a"), (r"\ud800", r"\ud800"),
     (r"\xg1", r"\xg1"), (r"\q", r"\q"), (r"\\x41", r"\x41"), (r"\U00110000", r"\U00110000")],
)  # fmt: skip
def test_escapes_with_a_number_are_resolved(written: str, meant: str) -> None:
    assert unescape(written) == meant


@pytest.mark.parametrize(
    ("literal", "unknown"),
    [(r'"a\qb"', [r"\q"]), (r"'\d+\.\d'", [r"\d", r"\.", r"\d"]), (r'"\\d\n\x41\u00e9"', []), (r'"\x4"', [r"\x"]),
     (r'"\ud800"', [r"\ud800"]), (r'"\101"', [r"\1"]), ('"""a\\\nb\\z"""', [r"\z"])],
)  # fmt: skip
def test_unknown_escapes_are_found(literal: str, unknown: list[str]) -> None:
    assert [literal[start:end] for start, end in unknown_escapes(literal)] == unknown

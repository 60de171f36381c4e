"""Diagnostics as text and as JSON."""

from __future__ import annotations

from pathlib import Path

from seoro.lang.diagnostic import Diagnostic, Label, Severity
from seoro.lang.diagnostics.types import not_a_value
from seoro.lang.render import render_text, to_json
from seoro.lang.source import SourceFile, Span
from tests.lang.helpers import check

FILE = SourceFile("maze.osc", "\n" * 13 + "    keep(it.reach == 2m + 3mps)\n\tx: int\n\n\n\n\nend\n")


def span(text: str) -> Span:
    start = FILE.text.index(text)
    return Span(FILE, start, start + len(text))


def error(code: str, at: Span, message: str, *others: Label, label: str = "", help: str = "") -> Diagnostic:  # noqa: A002
    return Diagnostic(Severity.ERROR, code, message, Label(at, label), others, help)


def test_labels_are_shown_below_their_line() -> None:
    found = error(
        "E0312",
        span("2m"),
        "`length` and `speed` cannot be added",
        Label(span("3mps"), "this is a speed"),
        label="this is a length",
        help="a `length` is a `speed` times a `time`",
    )
    assert render_text(found).splitlines() == [
        "error[E0312]: `length` and `speed` cannot be added",
        "  --> maze.osc:14:22",
        "   |",
        "14 |     keep(it.reach == 2m + 3mps)",
        "   |                      ^^   ---- this is a speed",
        "   |                      this is a length",
        "   = help: a `length` is a `speed` times a `time`",
    ]


def test_a_long_line_is_shown_around_the_mark() -> None:
    file = SourceFile("maze.osc", f"{'a' * 400}WRONG{'b' * 400}")
    shown = render_text(error("E0312", Span(file, 400, 405), "no", label="here")).splitlines()
    assert shown[3] == f"1 | ...{'a' * 49}WRONG{'b' * 146}..."
    assert shown[4] == f"  | {' ' * 52}^^^^^ here"


def test_long_messages_are_shortened_in_the_middle() -> None:
    found = not_a_value(span("2m"), "a" * 5000, "a label", hint="b" * 5000)
    assert found.message.startswith("`aaa")
    assert found.message.endswith("aaa` is a label, not a value")
    assert len(found.message) == len(found.help) == 1003


def test_tabs_are_expanded_and_lines_between_labels_omitted() -> None:
    found = error("E0101", span("x"), "what", Label(span("end"), "there"))
    assert render_text(found).splitlines()[2:] == [
        "   |",
        "15 |     x: int",
        "   |     ^",
        "...",
        "20 | end",
        "   | --- there",
    ]


def test_a_span_of_several_lines_is_marked_on_the_first_line() -> None:
    found = error("E0101", Span(FILE, span("3mps").start, span("end").end), "what")
    assert render_text(found).splitlines()[-1] == "   |                           ^^^^^"


def test_colours_add_escape_codes_only() -> None:
    found = error("E0101", span("x"), "what", label="here")
    coloured = render_text(found, colour=True)
    assert "\x1b[" in coloured
    for code in ("\x1b[0m", "\x1b[1m", "\x1b[31;1m", "\x1b[34;1m"):
        coloured = coloured.replace(code, "")
    assert coloured == render_text(found)


def test_json_is_flat_and_counts_from_one(tmp_path: Path) -> None:
    (found,) = check(tmp_path, "struct a:\n    n: int = 1.5\n").diagnostics
    assert to_json(found) == {
        "file": "test.osc",
        "line": 2,
        "column": 14,
        "end_line": 2,
        "end_column": 17,
        "severity": "error",
        "code": "E0301",
        "message": "expected `int` for `n`, found `float`",
        "help": "write an integer, or convert by `.as(int)`, which takes numbers without a fraction",
    }

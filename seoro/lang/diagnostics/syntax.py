"""Messages of reading and parsing (E0101 to E0140)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error, warning
from seoro.lang.escapes import ESCAPES
from seoro.lang.habits import CHARACTERS
from seoro.lang.source import Span


def unreadable_file(span: Span, name: str, reason: str) -> Diagnostic:
    """An unreadable file."""
    return error("E0101", span, f"cannot read `{name}`: {reason}")


def too_long(span: Span, limit: int) -> Diagnostic:
    """A statement with more tokens than supported."""
    text = f"cannot read `{span.file.name}`: a statement has more than {limit:,} words and signs"
    return error("E0101", span, text)


def unknown_character(span: Span) -> Diagnostic:
    """A character that starts no token."""
    shown = f"`{span.text}`" if span.text.isprintable() else f"U+{ord(span.text[0]):04X}"
    return error("E0110", span, f"unexpected character {shown}", CHARACTERS.get(span.text, ""))


def unclosed_string(span: Span, quotes: str) -> Diagnostic:
    """A string without its closing quotes."""
    text = f"this string is not closed by {quotes}"
    if len(quotes) == 3:
        return error("E0111", span, text)
    return error("E0111", span, f"{text} on its line", "write a string over several lines in three quotes")


def unclosed_bracket(span: Span, bracket: str) -> Diagnostic:
    """An opening bracket without its partner."""
    hint = f"add the missing `{')' if bracket == '(' else ']'}`"
    return error("E0112", span, f"`{bracket}` is not closed", hint, label="opened here")


def unknown_indentation(span: Span, columns: tuple[int, ...], mixes_tabs: bool) -> Diagnostic:
    """A line whose indentation is not that of an enclosing block."""
    hint = f"the enclosing blocks stand at {', '.join(map(str, columns))} columns"
    if mixes_tabs:
        hint += "; a tab goes to the next multiple of 8 columns, so do not mix tabs and spaces"
    return error("E0113", span, "this indentation matches no enclosing block", hint)


def unexpected_indentation(span: Span) -> Diagnostic:
    """An indented line where no block begins."""
    hint = "a block begins after a line that ends with `:`"
    return error("E0114", span, "unexpected indentation", hint, label="no block begins here")


def missing_block(span: Span, header: Span) -> Diagnostic:
    """A line that ends with `:` without an indented block below it."""
    text = "expected an indented block"
    hint = "indent the lines of the block"
    return error("E0115", span, text, hint, other=header, remark="the block of this line is missing")


def unexpected_token(span: Span, found: str, expected: tuple[str, ...], hint: str = "") -> Diagnostic:
    """A token that the grammar does not allow in its place."""
    wanted = " or ".join(filter(None, (", ".join(expected[:-1]), *expected[-1:])))
    text = f"unexpected {found}, expected {wanted}" if wanted else f"unexpected {found}"
    return error("E0120", span, text, hint)


def misplaced_statement(span: Span, word: str, place: str, hint: str = "") -> Diagnostic:
    """A known statement in the wrong place."""
    return error("E0121", span, f"`{word}` cannot stand {place}", hint)


def missing_colon(span: Span) -> Diagnostic:
    """A line that opens a block without a colon."""
    return error("E0122", span, "missing `:` before the block", "end a line that opens a block with `:`")


def late_import(span: Span) -> Diagnostic:
    """An import after other statements (7.2.2.1.1)."""
    return error("E0123", span, "`import` after other statements", "move the imports to the top of the file")


def integer_out_of_range(span: Span) -> Diagnostic:
    """An integer that exceeds both `int` and `uint`."""
    hint = "int holds -9223372036854775808 to 9223372036854775807, uint holds 0 to 18446744073709551615"
    return error("E0130", span, "this integer does not fit into 64 bits", hint)


def float_out_of_range(span: Span) -> Diagnostic:
    """A number that exceeds `float`."""
    hint = "the largest float is about 1.8e308; infinity is written `inf`"
    return error("E0131", span, "this number is too large for float", hint)


def mixed_arguments(span: Span) -> Diagnostic:
    """A positional argument after a named one."""
    hint = "positional arguments come first, then those with a name"
    return error("E0132", span, "positional argument after a named one", hint)


def too_deep(span: Span, limit: int) -> Diagnostic:
    """Nesting beyond the limit."""
    return error("E0133", span, f"nested more than {limit} levels deep", "give a part of it a name")


def too_nested(span: Span, limit: int) -> Diagnostic:
    """Nesting so deep that parsing stops.

    Args:
        span: The start.
        limit: About how many of the kind can be nested.
    """
    hint = f"at most {limit} of its kind can be nested; give a part of it a name"
    return error("E0133", span, f"nested too deeply (limit {limit})", hint)


def foreign_syntax(span: Span, text: str, hint: str) -> Diagnostic:
    """A statement or a sign of another language."""
    return error("E0138", span, text, hint)


def foreign_file(span: Span, kind: str) -> Diagnostic:
    """A file of another format."""
    hint = "seoro runs OpenSCENARIO DSL 2.x (`.osc`): write the scenario in it, or choose another file"
    return error("E0139", span, f"expected OpenSCENARIO DSL, found {kind}", hint)


def unknown_escape(span: Span) -> Diagnostic:
    """An unknown escape in a string."""
    text = f"unknown escape `{span.text}` in a string; the backslash is kept"
    return warning("E0140", span, text, f"write `\\{span.text}` for a backslash; escapes are {ESCAPES}")

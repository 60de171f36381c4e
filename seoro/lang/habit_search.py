"""Search for a habit of another language in a statement with a syntax error."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from functools import cache
from typing import Final

from seoro.lang.diagnostic import Diagnostic
from seoro.lang.diagnostics import listing, syntax
from seoro.lang.expression_habits import BLOCK, END, Habit
from seoro.lang.frozen import Frozen
from seoro.lang.lexer import Token
from seoro.lang.line_habits import HABITS
from seoro.lang.source import SourceFile, Span

MAX_WORDS: Final = 200  # searched words of a statement
_SHOWN: Final = {"_NEWLINE": END, "_INDENT": BLOCK, "_DEDENT": END, "$END": END, "STRING_LITERAL": '"'}


class Found(Frozen):
    """A habit in a statement.

    Args:
        habit: The habit.
        message: Its message.
        first: Index of the first faulty token.
        behind: Index after the last faulty token.
        repair: Replacement text of the faulty tokens; None if the statement is skipped.
    """

    habit: Habit
    message: Diagnostic
    first: int
    behind: int
    repair: str | None


def find(
    file: SourceFile, tokens: Sequence[Token], first: int, index: int, stands: Callable[[str], bool]
) -> Found | None:
    """Return the first habit that matches a statement, or None.

    Args:
        file: The text.
        tokens: Its tokens.
        first: The index of the first token of the statement.
        index: The index of the unexpected token.
        stands: Returns whether the statement stands in a place.
    """
    if index - first >= MAX_WORDS:
        return None
    words, starts = _lay_out(file, tokens[first : first + MAX_WORDS])
    at_fault = starts[index - first]
    for habit in HABITS:
        found = _pattern(habit).match(words)
        if (
            found is None
            or found.start("at") not in starts
            or not _concerns(found, habit, at_fault, index - first)
            or not stands(habit.place)
        ):
            continue
        near = _near(found["at"], habit.meant)
        if habit.meant and (not near or found["at"] in habit.meant):
            continue
        start = starts.index(found.start("at"))
        behind = next((number for number, offset in enumerate(starts) if offset >= found.end("at")), len(starts))
        span = Span(file, tokens[first + start].start, tokens[first + behind - 1].end)
        fields = {name: _joined(text) for name, text in found.groupdict().items() if text is not None}
        fields |= {"meant": listing(near, "or"), "only": near[0] if near else "", "at": span.text}
        if "number" in fields:
            fields["percent"] = f"{float(fields['number']) / 100:g}"
        message = syntax.foreign_syntax(span, habit.message.format(**fields), habit.help.format(**fields))
        repair = habit.repair.format(**fields) if habit.repair is not None else None
        return Found(habit, message, first + start, first + behind, repair)
    return None


def _concerns(found: re.Match[str], habit: Habit, at_fault: int, number: int) -> bool:
    """Return whether a habit explains the word at an offset, the `number`-th of the statement from 0."""
    if found.end() > at_fault:
        return True
    return found.start("at") == 0 and (not habit.meant or number <= 1)


def _lay_out(file: SourceFile, tokens: Sequence[Token]) -> tuple[str, list[int]]:
    """Join the words of a statement by single blanks; return the text and the offsets of the words.

    `BLOCK` represents a block of the statement.
    """
    parts: list[str] = []
    starts: list[int] = []
    offset = 0
    for token in tokens:
        is_line_end = bool(parts) and parts[-1] == END
        if (is_line_end and token.kind != "_INDENT") or (parts and token.kind in {"_DEDENT", "$END"}):
            break
        text = _SHOWN.get(token.kind) or file.text[token.start : token.end]
        parts.append(text)
        starts.append(offset)
        offset += len(text) + 1
        if text == BLOCK:
            break
    return " ".join(parts) + " ", starts


def _near(word: str, meant: Sequence[str]) -> list[str]:
    """Return the words of which a word may be a misspelling."""
    if word.lower() in meant:
        return [word.lower()]
    return get_close_matches(word.lower(), meant, n=2, cutoff=0.7)


def _joined(words: str) -> str:
    """Return words of a statement as in source text."""
    return re.sub(r" ?([.()]) ?", r"\1", words)


@cache
def _pattern(habit: Habit) -> re.Pattern[str]:
    return re.compile(habit.pattern)

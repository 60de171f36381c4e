"""Habit of another language: a pattern for the words of a statement, and the words to write instead."""

from __future__ import annotations

from typing import Final

from seoro.lang.frozen import Frozen

FILE, MEMBERS, BEHAVIORS, REACTIONS = "file", "members", "behaviors", "reactions"  # places of a statement
END: Final = "\n"  # end of a line, in the layout of a statement
BLOCK: Final = "\t"  # the beginning of a block


class Habit(Frozen):
    """A statement of another language.

    Args:
        pattern: A regular expression for the words of a statement. Its group `at` is the faulty part.
        message: The message; names of groups in braces are replaced by their matches.
        help: Help text, with the same replacements.
        repair: The words that replace `at`; None if the statement is skipped.
        place: The place in which the habit applies; empty for all.
        meant: Correct words for `{meant}`; the habit applies only if `at` resembles one of them.
        tails: First words of further parts of the same statement, which are skipped with it.
    """

    pattern: str
    message: str
    help: str
    repair: str | None = None
    place: str = ""
    meant: tuple[str, ...] = ()
    tails: tuple[str, ...] = ()

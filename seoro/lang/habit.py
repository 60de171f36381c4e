"""Habit of another language: a pattern for the words of a statement, and the words to write instead."""

from __future__ import annotations

from typing import Final

from seoro.lang.frozen import Frozen

FILE, MEMBERS, BEHAVIORS, REACTIONS = "file", "members", "behaviors", "reactions"  # where statements stand
END: Final = "\n"  # of a line, in the layout of a statement
BLOCK: Final = "\t"  # the beginning of a block


class Habit(Frozen):
    """A statement as another language has it.

    Args:
        pattern: A regular expression for the words of a statement. Its group `at` is what is at fault.
        message: The message; names of groups in braces stand for what they matched.
        help: How to repair it.
        repair: The words that replace `at`; None if the statement is skipped.
        place: Where statements of this kind stand; empty for everywhere.
        meant: What `at` may be a misspelling of, for `{meant}`; the habit is passed over if nothing comes near.
        tails: Words with which further parts of the same statement begin, which are skipped with it.
    """

    pattern: str
    message: str
    help: str
    repair: str | None = None
    place: str = ""
    meant: tuple[str, ...] = ()
    tails: tuple[str, ...] = ()

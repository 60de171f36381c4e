"""Comments behind statements: those that stood below each other still do, with the lines that continue them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from typing import NamedTuple

from seoro.lang.format.lines import Comment, Gap


class OutLine(NamedTuple):
    """A line to be written: its text and the comment behind it; without text, the comment has it for itself."""

    text: str
    comment: Comment | None = None


def take_continuation(out: list[OutLine], gap: Gap, below: int) -> Gap:
    """Move comments that stand right below one behind a statement to the lines; gives what is left of the gap.

    Args:
        out: The lines before the gap.
        gap: What stands between two statements.
        below: The column of the statement below, to which comments at the same column belong.
    """
    taken = 0
    if out and (last := out[-1].comment) is not None:
        for comment in gap.comments:
            if comment.after_blank or comment.column != last.column or comment.column == below:
                break
            out.append(OutLine("", comment))
            taken += 1
    return gap._replace(comments=gap.comments[taken:])


def align(lines: list[OutLine]) -> Iterator[str]:
    """The lines with their comments: two blanks behind the longest statement of those that were aligned."""
    for column, run in groupby(lines, key=lambda line: line.comment.column if line.comment else None):
        members = list(run)
        width = max(len(line.text.rsplit("\n", 1)[-1]) for line in members)
        for text, comment in members:
            if column is None or comment is None:
                yield text
            else:
                shown = len(text.rsplit("\n", 1)[-1])
                yield f"{text}{' ' * (width - shown + 2)}{comment.text}"

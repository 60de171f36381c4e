"""Alignment of comments after statements, with the comment lines that continue them."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import groupby
from typing import NamedTuple

from seoro.lang.format.lines import Comment, Gap


class OutLine(NamedTuple):
    """An output line: its text, which may be empty, and the comment after it."""

    text: str
    comment: Comment | None = None


def take_continuation(out: list[OutLine], gap: Gap, below: int) -> Gap:
    """Move comments directly below a comment after a statement to the output; return the rest of the gap.

    Args:
        out: The lines before the gap.
        gap: Comments and blank lines between two statements.
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
    """Yield the lines, with aligned comments two blanks after the longest statement among them."""
    for column, run in groupby(lines, key=lambda line: line.comment.column if line.comment else None):
        members = list(run)
        width = max(len(line.text.rsplit("\n", 1)[-1]) for line in members)
        for text, comment in members:
            if column is None or comment is None:
                yield text
            else:
                shown = len(text.rsplit("\n", 1)[-1])
                yield f"{text}{' ' * (width - shown + 2)}{comment.text}"

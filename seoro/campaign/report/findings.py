"""Section of the report about failed runs that were shrunk, or whose neighbours are known."""

from __future__ import annotations

import shlex
from collections.abc import Iterable, Iterator, Sequence
from html import escape
from pathlib import Path
from typing import Final

from seoro.campaign.after.findings import Shrunk, Surroundings, read_shrunk, read_surroundings

MOST_LETTERS: Final = 300  # of a text of a run


def findings(folder: Path) -> Iterator[str]:
    """Yield the simplest failing values of failed runs, and how far away they pass.

    Args:
        folder: Folder of the campaign.

    Raises:
        UsageError: A file of a result is invalid.
        OSError: It cannot be read.
    """
    shrunk = [each for each in read_shrunk(folder) if each.has_failed]
    around = list(read_surroundings(folder))
    if not shrunk and not around:
        return
    yield "<h2>Failed runs in detail</h2>"
    for each in shrunk:
        yield from _shrunk(each, folder)
    for surroundings in around:
        yield from _surroundings(surroundings)


def _shrunk(found: Shrunk, folder: Path) -> Iterator[str]:
    note = "no parameter can be one step simpler" if found.outcome == "minimal" else "there may be simpler values"
    yield f'<div class="card wide"><h3>Run {found.run}, shrunk</h3><p>{_text(found.reason)}; {note}.</p>'
    lines = [[path, found.before[path], text, _yes(found.matters(path))] for path, text in found.values.items()]
    yield _table(["parameter", f"run {found.run}", "shrunk", "matters"], lines)
    command = shlex.join(["seoro", "campaign", "shrink", str(folder), str(found.run)])
    yield f'<p class="note">It becomes a scenario file by:</p><pre>{escape(command)}</pre></div>'


def _surroundings(found: Surroundings) -> Iterator[str]:
    yield f'<div class="card wide"><h3>Neighbours of run {found.run}</h3><p>{_text(found.reason)}</p>'
    lines = [[each.path, each.value, each.below, each.above, _yes(each.matters)] for each in found.parameters]
    yield _table(["parameter", f"run {found.run}", "below", "above", "matters"], lines)
    yield "</div>"


def _table(titles: Sequence[str], lines: Iterable[Sequence[str]]) -> str:
    head = "".join(f"<th>{_text(title)}</th>" for title in titles)
    rows = "".join(f"<tr>{''.join(f'<td>{_text(cell)}</td>' for cell in line)}</tr>" for line in lines)
    return f'<div class="scroll"><table><tr>{head}</tr>{rows}</table></div>'


def _yes(value: bool) -> str:
    return "yes" if value else "no"


def _text(text: str) -> str:
    return escape(text if len(text) <= MOST_LETTERS else text[: MOST_LETTERS - 1] + "\u2026")

"""Check of a rename: apply it, and require that all other names keep their meaning."""

from __future__ import annotations

from bisect import bisect_left
from collections.abc import Iterable, Mapping
from itertools import chain
from pathlib import Path
from typing import TypeAlias

from seoro.lang.source import Span
from seoro.lsp.analysis import Analysis, analyse
from seoro.lsp.documents import Texts
from seoro.lsp.index import Place
from seoro.lsp.meaning import Meaning, name_of
from seoro.lsp.navigation import CannotRename

Edits: TypeAlias = Mapping[Path, list[Span]]  # the texts that the new name replaces, by file


def check_collisions(edits: Edits, new: str, analyses: Iterable[Analysis], texts: Texts) -> None:
    """Apply a new name in all programs that read an edited file, and compare the results.

    Args:
        edits: The spans that the new name replaces.
        new: The new name.
        analyses: Programs that may read the edited files.
        texts: The open documents.

    Raises:
        CannotRename: A program would be invalid, or a name in it would change its meaning.
    """
    changed = {path: _edited(spans, new) for path, spans in edits.items() if spans}
    moves = _Moves(edits, len(new))
    tried: set[Path] = set()
    for before in analyses:
        if before.path in tried or changed.keys().isdisjoint(before.files.by_path):
            continue
        tried.add(before.path)
        after = analyse(before.path, {**texts, **changed})
        _compare_errors(before, after, moves, new)
        _compare_names(before, after, moves, new)
        _compare_members(before, after, moves, new)


class _Moves:
    """Positions in the texts after the new name has replaced the old one."""

    def __init__(self, edits: Edits, length: int) -> None:
        self._starts = {path: sorted(span.start for span in spans) for path, spans in edits.items()}
        self._growth = {path: length - (spans[0].end - spans[0].start) for path, spans in edits.items() if spans}

    def offset(self, path: Path, offset: int) -> int:
        """Return the new offset of one outside of a name, or at its start."""
        return offset + bisect_left(self._starts.get(path, []), offset) * self._growth.get(path, 0)

    def place(self, place: Place | None) -> Place | None:
        """Return the new range of a declaration; None without one."""
        if place is None:
            return None
        path, start, end = place
        return path, self.offset(path, start), self.offset(path, end)


def _edited(spans: list[Span], new: str) -> str:
    """Return the text of a file with the new name."""
    text, parts, offset = spans[0].file.text, [], 0
    for span in sorted(spans, key=lambda span: span.start):
        parts += [text[offset : span.start], new]
        offset = span.end
    return "".join((*parts, text[offset:]))


def _compare_errors(before: Analysis, after: Analysis, moves: _Moves, new: str) -> None:
    """Reject a name that causes new errors."""
    known = set()
    for found in before.checked.errors:
        path = before.files.path_of(found.primary.span.file)
        if path is not None:
            known.add((found.code, path, moves.offset(path, found.primary.span.start)))
    for found in after.checked.errors:
        span = found.primary.span
        if (found.code, after.files.path_of(span.file), span.start) not in known:
            raise CannotRename(f"`{new}` is in use: {found.message} ({span})")


def _compare_names(before: Analysis, after: Analysis, moves: _Moves, new: str) -> None:
    """Reject a name that captures other uses, or loses some to another declaration."""
    for path in before.files.by_path:
        there = {(use.span.start, use.span.end): use for use in after.index.uses(path)}
        for use in before.index.uses(path):
            other = there.get((moves.offset(path, use.span.start), moves.offset(path, use.span.end)))
            target = moves.place(before.index.target(use.meaning))
            if other is None or after.index.target(other.meaning) != target:
                raise CannotRename(
                    f"`{new}` is in use: `{name_of(use.meaning)}` at {use.span} would change its meaning"
                )


def _compare_members(before: Analysis, after: Analysis, moves: _Moves, new: str) -> None:
    """Reject a name that changes which members of a type override each other."""
    new_members = _members(after)
    for owner, members in _members(before).items():
        if new_members.get(moves.place(owner)) != set(map(moves.place, members)):
            raise CannotRename(f"`{new}` changes which members override each other; rename all of them")


def _members(analysis: Analysis) -> dict[Place | None, set[Place | None]]:
    """Return the declarations of each type's members, by the place of the type."""
    target = analysis.index.target
    found: dict[Place | None, set[Place | None]] = {}
    for symbol in analysis.checked.program.structured():
        inventory = symbol.inventory
        tables = inventory.fields.values(), inventory.events.values(), inventory.methods.values()
        found[target(symbol)] = set(map(target, chain[Meaning](*tables)))
    return found

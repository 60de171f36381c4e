"""Declarations and uses of names, members that override each other, and edits of a rename."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from itertools import product
from pathlib import Path

from seoro.lang.diagnostic import Bag
from seoro.lang.lexer import Lexer
from seoro.lang.members import M
from seoro.lang.source import SourceFile, Span
from seoro.lang.symbols import EventSymbol, MethodSymbol
from seoro.lsp.analysis import Analysis, library_at
from seoro.lsp.index import Place, Use
from seoro.lsp.meaning import ImportedFile, name_of


def declared_at(analysis: Analysis, offset: int) -> tuple[Path, Span] | None:
    """Return the declaration of the name at an offset; for an import, the start of the file."""
    use = analysis.index.at(analysis.path, offset)
    if use is None:
        return None
    if isinstance(use.meaning, ImportedFile):
        path = use.meaning.path
        file = analysis.files.by_path.get(path)
        return (path, Span(file, 0, 0)) if file is not None else None
    target = analysis.index.target(use.meaning)
    return (target[0], Span(analysis.files.by_path[target[0]], *target[1:])) if target is not None else None


def target_at(analysis: Analysis, offset: int) -> tuple[Use, Place] | None:
    """Return the name at an offset, and the place of its declaration."""
    use = analysis.index.at(analysis.path, offset)
    target = analysis.index.target(use.meaning) if use is not None else None
    return (use, target) if use is not None and target is not None else None


def uses(declared: Iterable[Place], analyses: Iterable[Analysis]) -> dict[Path, list[Span]]:
    """Return all uses of declarations, by file."""
    found: dict[tuple[Path, int, int], Span] = {}
    for analysis, target in product(analyses, declared):
        for span in analysis.index.uses_of(target):
            path = analysis.files.path_of(span.file)
            if path is not None:
                found[path, span.start, span.end] = span
    by_file: dict[Path, list[Span]] = {}
    for (path, _, _), span in sorted(found.items(), key=lambda item: item[0]):
        by_file.setdefault(path, []).append(span)
    return by_file


class CannotRename(Exception):
    """A name cannot be changed; the text has the reason."""


def check_rename(analysis: Analysis, offset: int) -> tuple[str, Span, Place]:
    """Return the name at an offset, its span without prefix, and the place of its declaration.

    Raises:
        CannotRename: The offset has no name, or a name of a library.
    """
    found = target_at(analysis, offset)
    if found is None:
        raise CannotRename("no name that can be renamed here")
    use, target = found
    name, library = name_of(use.meaning), library_at(target[0])
    if library is not None:
        raise CannotRename(f"`{name}` is declared in the library `{library}`")
    return name, bare(use.span, name), target


def bare(span: Span, name: str) -> Span:
    """Return the span of the identifier in a name, without namespace or enumeration."""
    text = span.text
    return Span(span.file, span.end - len(name), span.end) if text.endswith(name) else span


def edits(target: Place, name: str, new: str, analyses: Sequence[Analysis]) -> dict[Path, list[Span]]:
    """Return the spans that a new name replaces, by file, including overriding and overridden members.

    Raises:
        CannotRename: The new name is invalid, or a use is in a library.
    """
    if not is_identifier(new):
        raise CannotRename(
            f"invalid identifier `{new}`: expected letters, digits and underscores, not beginning with a digit"
        )
    declared = family(target, analyses)
    for path, _, _ in sorted(declared):
        library = library_at(path)
        if library is not None:
            raise CannotRename(f"`{name}` overrides a member of the library `{library}`")
    found = uses(declared, analyses)
    for path, spans in found.items():
        library = library_at(path)
        if library is not None:
            raise CannotRename(f"`{name}` is used in the library `{library}`")
        found[path] = [bare(span, name) for span in spans]
    return found


def is_identifier(text: str) -> bool:
    """Return whether a text is an identifier."""
    bag = Bag()
    first = Lexer(SourceFile("name", text), bag).tokens()[0]
    return (first.kind, first.start, first.end, len(bag)) == ("NAME", 0, len(text), 0)


def family(target: Place, analyses: Iterable[Analysis]) -> set[Place]:
    """Return the places of a declaration and of all that override it or that it overrides, in any step."""
    neighbours: dict[Place, set[Place]] = {}
    for analysis in analyses:
        for one, other in _overrides(analysis):
            neighbours.setdefault(one, set()).add(other)
            neighbours.setdefault(other, set()).add(one)
    found: set[Place] = set()
    pending = {target}
    while pending:
        found |= pending
        pending = {near for place in pending for near in neighbours.get(place, ())} - found
    return found


def _overrides(analysis: Analysis) -> Iterator[tuple[Place, Place]]:
    """Yield the places of declarations, each with that of the nearest overridden one."""
    target = analysis.index.target
    for symbol in analysis.checked.program.structured():
        if symbol.base is None:
            continue
        inherited = symbol.base.inventory
        pairs: list[tuple[EventSymbol | MethodSymbol, EventSymbol | MethodSymbol]]
        pairs = [*_alike(symbol.events, inherited.events), *_alike(symbol.methods, inherited.methods)]
        for own, overridden in pairs:
            for one, other in ((own, overridden), *_alike(own.parameters, overridden.parameters)):
                places = target(one), target(other)
                if places[0] is not None and places[1] is not None:
                    yield places[0], places[1]


def _alike(own: Mapping[str, M], inherited: Mapping[str, M]) -> Iterator[tuple[M, M]]:
    """Yield members, each with the inherited one of its name."""
    return ((member, inherited[name]) for name, member in own.items() if name in inherited)

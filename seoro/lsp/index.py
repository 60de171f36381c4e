"""Index of a program: the meanings of all names, and the types of expressions."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import dataclass, field
from pathlib import Path
from typing import cast

from seoro.files.inputs import resolved
from seoro.lang.check.checker import Checked
from seoro.lang.loader import Module
from seoro.lang.source import SourceFile, Span
from seoro.lang.symbols import Type, Unknown
from seoro.lsp.local_names import imports, local_names
from seoro.lsp.meaning import Meaning, declarations, definition

_NESTED = 8  # names within names, as in `color!red`, and some more

Place = tuple[Path, int, int]  # a file, and offsets of the start and the end in its text


@dataclass
class Notes:
    """Recorder of a check."""

    names: dict[tuple[SourceFile, int, int], Meaning] = field(default_factory=dict)
    values: dict[tuple[SourceFile, int, int], Type] = field(default_factory=dict)

    def name(self, span: Span, meaning: object) -> None:
        """Implement `Recorder`."""
        self.names[span.file, span.start, span.end] = cast(Meaning, meaning)

    def value(self, span: Span, type_: Type) -> None:
        """Implement `Recorder`."""
        if not isinstance(type_, Unknown):
            self.values[span.file, span.start, span.end] = type_


@dataclass(frozen=True)
class Use:
    """A name in the text."""

    span: Span
    meaning: Meaning


class Files:
    """The files of a program and their resolved paths, which identify files of several programs.

    Args:
        modules: The files.
    """

    def __init__(self, modules: Iterable[Module]) -> None:
        self._paths = {
            module.file: resolved(module.file.path) for module in modules if module.file.path is not None
        }
        self.by_path = {path: file for file, path in self._paths.items()}

    def path_of(self, file: SourceFile) -> Path | None:
        """Return the resolved path of a file; None for other texts, such as an option."""
        return self._paths.get(file)


class Index:
    """Finds names by place and places by name.

    Args:
        checked: The program.
        notes: Records of its check.
        files: Its files.
    """

    def __init__(self, checked: Checked, notes: Notes, files: Files) -> None:
        uses: dict[tuple[SourceFile, int, int], Use] = {}

        def add(found: Iterable[tuple[Span, Meaning]]) -> None:
            """Add names without a meaning: a label may have the name of a field."""
            for span, meaning in found:
                uses.setdefault((span.file, span.start, span.end), Use(span, meaning))

        add((Span(*place), meaning) for place, meaning in notes.names.items())
        declared = [(span, meaning) for meaning in declarations(checked.program) if (span := definition(meaning))]
        add(declared)
        at = {(span.file, span.start): meaning for span, meaning in declared}
        for module in checked.sources.modules:
            add(local_names(module.tree, at))
            add(imports(module))
        self._files = files
        self._uses: dict[Path, list[Use]] = {path: [] for path in files.by_path}
        self._values: dict[Path, list[tuple[Span, Type]]] = {path: [] for path in files.by_path}
        self._places: dict[Place, list[Span]] = {}
        for use in uses.values():
            self._add(use)
        for place, type_ in notes.values.items():
            path = files.path_of(place[0])
            if path is not None:
                self._values[path].append((Span(*place), type_))
        for found in self._uses.values():
            found.sort(key=lambda use: (use.span.start, -use.span.end))

    def _add(self, use: Use) -> None:
        path = self._files.path_of(use.span.file)
        if path is None:
            return
        self._uses[path].append(use)
        target = self.target(use.meaning)
        if target is not None:
            self._places.setdefault(target, []).append(use.span)

    def at(self, path: Path, offset: int) -> Use | None:
        """Return the shortest name at an offset, or directly before it."""
        uses = self._uses.get(path, [])
        last = bisect_right(uses, offset, key=lambda use: use.span.start)
        near = [use for use in uses[max(0, last - _NESTED) : last] if offset <= use.span.end]
        inside = [use for use in near if offset < use.span.end]
        return min(inside or near, key=lambda use: use.span.end - use.span.start, default=None)

    def uses(self, path: Path) -> tuple[Use, ...]:
        """Return all names in a file, in order."""
        return tuple(self._uses.get(path, ()))

    def type_at(self, path: Path, offset: int) -> tuple[Span, Type] | None:
        """Return the shortest expression at an offset, with its type."""
        here = [found for found in self._values.get(path, []) if found[0].start <= offset <= found[0].end]
        return min(here, key=lambda found: found[0].end - found[0].start, default=None)

    def target(self, meaning: Meaning) -> Place | None:
        """Return the place of a declaration, which is the same in all programs that read the file."""
        span = definition(meaning)
        path = self._files.path_of(span.file) if span is not None else None
        return (path, span.start, span.end) if span is not None and path is not None else None

    def uses_of(self, target: Place) -> tuple[Span, ...]:
        """Return all uses of a declaration, including itself."""
        return tuple(self._places.get(target, ()))

"""Reading of documented libraries, by the checker."""

from __future__ import annotations

import inspect
from collections.abc import Iterable, Iterator, Mapping
from importlib import import_module
from itertools import takewhile
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.bindings.bound_functions import BoundFunctions
from seoro.cli.documentation.items import Item, Library, Parameter
from seoro.embed.scenarios import Scenario, check_file
from seoro.errors import UsageError
from seoro.files.inputs import failure_reason
from seoro.lang.ast import ExternalMethod
from seoro.lang.builtin_libraries import builtin_libraries
from seoro.lang.comments import comment_above
from seoro.lang.libraries import library_files
from seoro.lang.loader import Unreadable, read_file
from seoro.lang.program import Program
from seoro.lang.source import SourceFile, Span
from seoro.lang.symbols import EnumSymbol, FieldSymbol, Kind, MethodImplementation, QuantitySymbol, TypeSymbol
from seoro.lang.units import unit_text
from seoro.lsp.describe import parameter_text, type_text, unit_of

if TYPE_CHECKING:
    from seoro.runtime.functions.actions import BoundAction
    from seoro.runtime.functions.modifiers import BoundModifier

ENTRY: Final = "documentation.osc"  # a file that exists in memory only


def known_libraries(folder: Path) -> dict[str, Path]:
    """Return the files of the libraries that scenarios in a folder can import, by name; each file once.

    Raises:
        UsageError: The settings of the project are invalid.
    """
    found: dict[Path, str] = {}
    for name, path in sorted(library_files(folder / ENTRY).items(), key=lambda item: (len(item[0]), item[0])):
        found.setdefault(path, name)
    return {name: path for path, name in sorted(found.items(), key=lambda item: item[1])}


def heading(path: Path) -> str:
    """Return the comment at the start of a file, in one line; empty for a file that cannot be read."""
    text = read_file(path)
    if isinstance(text, Unreadable):
        return ""
    lines = takewhile(lambda line: line.startswith("#"), text.splitlines())
    return " ".join(line.lstrip("# ") for line in lines)


def read_libraries(libraries: Mapping[str, Path], folder: Path) -> tuple[Library, ...]:
    """Read libraries.

    Args:
        libraries: Their files, by the names to import.
        folder: Folder of the scenarios that import them.

    Raises:
        InvalidScenario: A library has errors.
    """
    entry = folder / ENTRY
    text = "".join(f"import {name}\n" for name in libraries)
    checked = check_file(entry, import_python=False, read=lambda path: text if path == entry else read_file(path))
    return tuple(_library(checked.without_errors(), name, path) for name, path in libraries.items())


def read_source(path: Path) -> Library:
    """Read the declarations of a scenario file.

    Raises:
        InvalidScenario: The file has errors.
        UsageError: It cannot be read.
    """
    try:
        path.stat()
    except OSError as error:
        raise UsageError(f"cannot read {path}: {failure_reason(error)}") from error
    return _library(check_file(path, import_python=False).without_errors(), str(path), path)


def _library(scenario: Scenario, name: str, path: Path) -> Library:
    full = path.resolve()
    [file] = (each for each in scenario.files if each.path is not None and each.path.resolve() == full)
    is_own = path in builtin_libraries().values()  # Python of others is not imported
    reader = _Reader(scenario.checked.program, scenario.functions, name, file, is_own=is_own)
    return Library(name, heading(path), tuple(reader.items()))


class _Reader:
    """Reads the declarations of one file.

    Args:
        program: Program with the file.
        functions: Functions that implement its actions and modifiers.
        library: Name of the library.
        file: The file.
        is_own: Whether it belongs to seoro, so that missing functions are known.
    """

    def __init__(
        self, program: Program, functions: BoundFunctions, library: str, file: SourceFile, *, is_own: bool
    ) -> None:
        self._program, self._functions, self._library = program, functions, library
        self._file, self._is_own = file, is_own

    def items(self) -> Iterator[Item]:
        """Yield the declarations of the file, in their order."""
        program = self._program
        tables = (program.types, program.globals, program.behaviors, program.modifiers)
        here = (symbol for table in tables for symbol in table.values() if symbol.span.file is self._file)
        yield from map(self._item, sorted(here, key=lambda symbol: symbol.span.start))

    def _item(self, symbol: TypeSymbol | EnumSymbol | QuantitySymbol | FieldSymbol) -> Item:
        match symbol:
            case TypeSymbol():
                return self._type(symbol)
            case EnumSymbol():
                values = tuple(f"{name} = {number}" for name, number in symbol.members.items())
                return Item("enum", symbol.name, self._library, _comment(symbol.span), values=values)
            case QuantitySymbol():
                unit, values = unit_text(symbol.dimension), tuple(self._units(symbol))
                return Item("type", symbol.name, self._library, _comment(symbol.span), result=unit, values=values)
            case FieldSymbol():
                of = type_text(symbol.type, self._program)
                return Item("global", symbol.text, self._library, _comment(symbol.span), result=of)

    def _units(self, symbol: QuantitySymbol) -> Iterator[str]:
        for unit in self._program.units.values():
            if unit.dimension == symbol.dimension:
                yield f"{unit.name} = {unit.factor:g}{f' + {unit.offset:g}' if unit.offset else ''}"

    def _type(self, symbol: TypeSymbol) -> Item:
        name = symbol.qualified_name
        bound = self._bound(symbol.kind, name)
        meaning = _comment(Span(symbol.span.file, symbol.declaration.span.start, symbol.span.end))
        is_called = symbol.kind in (Kind.ACTION, Kind.MODIFIER)
        return Item(
            symbol.kind.value,
            name,
            self._library,
            meaning or ("" if bound is None else _docstring(bound.function)),
            tuple(self._parameters(symbol.inventory.fields.values(), symbol)),
            inherits=symbol.base.qualified_name if symbol.base is not None else "",
            members=tuple(self._members(symbol)),
            is_implemented=not (is_called and self._is_own) or bound is not None or symbol.do is not None,
        )

    def _bound(self, kind: Kind, name: str) -> BoundAction | BoundModifier | None:
        actions, modifiers = self._functions.actions, self._functions.modifiers
        return actions.get(name) if kind is Kind.ACTION else modifiers.get(name) if kind is Kind.MODIFIER else None

    def _parameters(self, fields: Iterable[FieldSymbol], owner: TypeSymbol | None) -> Iterator[Parameter]:
        for field in fields:
            default = parameter_text(field, self._program).partition(" = ")[2]
            of = "" if field.owner is None or field.owner is owner else field.owner.qualified_name
            text = type_text(field.type, self._program)
            yield Parameter(field.text, text, unit_of(field.type), default, _comment(field.span), of)

    def _members(self, symbol: TypeSymbol) -> Iterator[Item]:
        for event in symbol.events.values():
            yield Item("event", f"{symbol.name}.{event.text}", self._library, _comment(event.span))
        for method in symbol.methods.values():
            result = "" if method.result is None else type_text(method.result, self._program)
            yield Item(
                "method",
                f"{symbol.name}.{method.text}",
                self._library,
                _comment(method.span) or _about(method.implementation),
                tuple(self._parameters(method.parameters.values(), symbol)),
                result=result,
            )


def _comment(span: Span) -> str:
    return " ".join(comment_above(span.file, span.line).split())


def _about(implementation: MethodImplementation) -> str:
    """Return the docstring of a method that seoro implements in Python; empty for others."""
    if not isinstance(implementation, ExternalMethod) or implementation.path[0] != "seoro":
        return ""
    *module, name = implementation.path
    return _docstring(getattr(import_module(".".join(module)), name))


def _docstring(function: object) -> str:
    """Return the first paragraph of a function's docstring, in one line."""
    paragraph = (inspect.getdoc(function) or "").partition("\n\n")[0]
    return " ".join(paragraph.split())

"""Finds libraries, which scenarios import as `osc.<name>`.

There are three kinds, looked for in this order:

- seoro's own, in `library/`;
- those in the folder `seoro.libraries` beside the scenario file: `name.osc`, or `name/name.osc`;
- those of installed packages: the entry-point group `seoro.libraries` has `name = "package.module"`, and
  `name.osc` is in the folder of that module.

Nothing of a library is run to find it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from enum import Enum
from importlib.machinery import PathFinder
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from seoro.lang.diagnostic import Message
from seoro.lang.diagnostics import imports
from seoro.lang.frozen import Value
from seoro.lang.source import SourceFile, Span

if TYPE_CHECKING:
    from importlib.machinery import ModuleSpec

Report: TypeAlias = Callable[[Message], None]

FOLDER = "seoro.libraries"  # beside the scenario file
ENTRY_POINTS = "seoro.libraries"  # the group of installed packages
_OWN = Path(__file__).with_name("library")

STANDARD_MODULES: Mapping[str, tuple[str, frozenset[str]]] = {
    "osc.types": ("types.osc", frozenset({"stdtypes"})),
    "osc.standard": ("standard.osc", frozenset({"std", "stdtypes"})),
    "osc.standard.all": ("standard.osc", frozenset()),
    "osc.standard.types": ("types.osc", frozenset()),
}
"""The modules whose file has another name, with the namespaces that they put in use."""


class Origin(Enum):
    """Where a library comes from."""

    OWN = "seoro itself"
    BESIDE = "the folder beside the scenario"
    INSTALLED = "an installed package"


class Library(Value):
    """A library that was found.

    Args:
        name: What was imported, such as `osc.nav2`.
        origin: Where it comes from.
        path: The file with its declarations.
        shown: How messages call that file.
        module: The Python module that may carry out what it declares: its name in `FOLDER`, or that of the entry
            point; empty for seoro's own.
        span: Where it was imported first.
    """

    name: str
    origin: Origin
    path: Path
    shown: str
    module: str
    span: Span


def find_library(name: str, span: Span, entry: SourceFile, report: Report) -> Library | None:
    """The library of a name; None if there is none, which is reported.

    Args:
        name: What is imported.
        span: Where.
        entry: The scenario file.
        report: Called with what is wrong.
    """
    beside = _beside(name, entry)
    own = own_libraries().get(name)
    if own is not None:
        if beside is not None:
            report(imports.OwnName(span, name, _shown(beside, entry)))
        return Library(name, Origin.OWN, own, f"<{name}>", "", span)
    bare = name.removeprefix("osc.")
    if beside is not None:
        return Library(name, Origin.BESIDE, beside, _shown(beside, entry), bare, span)
    return _installed(name, bare, span, entry, report)


def own_libraries() -> dict[str, Path]:
    """Modules of seoro's own libraries."""
    found = {f"osc.{path.stem}": path for path in sorted(_OWN.glob("*.osc"))}
    return {**found, **{name: _OWN / file for name, (file, _) in STANDARD_MODULES.items()}}


def library_files(scenario: Path | None) -> dict[str, Path]:
    """The files of all libraries that a scenario can import, by what it imports.

    Args:
        scenario: Its file; None for the libraries that all can import.
    """
    return {**_installed_files(), **(_files_beside(scenario) if scenario is not None else {}), **own_libraries()}


def library_file(name: str, scenario: Path | None) -> Path | None:
    """The file of one library that a scenario can import; None if there is none."""
    return own_libraries().get(name) or library_files(scenario).get(name)


# ---------------------------------------------------------------- beside the scenario


def _folder_of(scenario: Path) -> Path:
    """The folder that may hold libraries: beside a scenario file, or around the file of a library itself."""
    return folder_around(scenario) or scenario.absolute().parent / FOLDER


def folder_around(path: Path) -> Path | None:
    """The folder of libraries to which a file belongs; None if it belongs to none."""
    return next((folder for folder in path.absolute().parents[:2] if folder.name == FOLDER), None)


def _beside(name: str, entry: SourceFile) -> Path | None:
    """The file of a library in the folder beside a scenario file."""
    bare = name.removeprefix("osc.")
    if entry.path is None or "." in bare or bare == name:
        return None
    folder = _folder_of(entry.path)
    candidates = (folder / f"{bare}.osc", folder / bare / f"{bare}.osc")
    return next((path for path in candidates if path.is_file()), None)


def _shown(path: Path, entry: SourceFile) -> str:
    """A file beside the scenario, as the user would name it."""
    assert entry.path is not None
    folder = entry.path.absolute().parent
    return str(Path(entry.name).parent / path.relative_to(folder)) if path.is_relative_to(folder) else str(path)


def _files_beside(scenario: Path) -> dict[str, Path]:
    """The files of all libraries in the folder beside a scenario file."""
    folder = _folder_of(scenario)
    packages = (path for path in folder.glob("*/*.osc") if path.stem == path.parent.name)
    return {f"osc.{path.stem}": path for path in (*packages, *folder.glob("*.osc"))}


# ---------------------------------------------------------------- installed packages


def _installed(name: str, bare: str, span: Span, entry: SourceFile, report: Report) -> Library | None:
    from importlib.metadata import entry_points  # noqa: PLC0415 - slow, and seldom needed

    points = entry_points(group=ENTRY_POINTS)
    modules = sorted({point.module for point in points if point.name == bare}) if bare != name else []
    if not modules:
        report(imports.UnknownModule(span, name, tuple(sorted(library_files(entry.path)))))
        return None
    if len(modules) > 1:
        report(imports.AmbiguousLibrary(span, name, tuple(modules)))
        return None
    origin = _locate(modules[0])
    if origin is None:
        report(imports.NoModule(span, name, modules[0]))
        return None
    return Library(name, Origin.INSTALLED, origin.parent / f"{bare}.osc", f"<{name}>", modules[0], span)


def _installed_files() -> dict[str, Path]:
    """The files of all libraries of installed packages."""
    from importlib.metadata import entry_points  # noqa: PLC0415 - slow, and seldom needed

    found = ((point.name, _locate(point.module)) for point in entry_points(group=ENTRY_POINTS))
    return {f"osc.{name}": origin.parent / f"{name}.osc" for name, origin in found if origin is not None}


def _locate(module: str) -> Path | None:
    """The file of a Python module; none of it, nor of the packages around it, is run."""
    from importlib.util import find_spec  # noqa: PLC0415 - seldom needed

    top, *rest = module.split(".")
    try:
        spec: ModuleSpec | None = find_spec(top)
    except (ImportError, ValueError):
        return None
    name = top
    for part in rest:
        if spec is None or spec.submodule_search_locations is None:
            return None
        name = f"{name}.{part}"
        spec = PathFinder.find_spec(name, spec.submodule_search_locations)
    return Path(spec.origin) if spec is not None and spec.has_location and spec.origin is not None else None

"""Search for libraries, which scenarios import as `osc.<name>`.

The search order is:

- built-in libraries, in `library/`;
- the folder `seoro.libraries` beside the scenario file: `name.osc`, or `name/name.osc`;
- folders that the settings of the project name, with the same files;
- installed packages: the entry-point group `seoro.libraries` has `name = "package.module"`, and `name.osc` is in
  the folder of that module;
- installed packages for scenario_execution (`plugin_libraries.py`).

The search runs no code of a library.
"""

from __future__ import annotations

import os
from collections.abc import Callable
from enum import Enum
from pathlib import Path
from typing import TYPE_CHECKING, TypeAlias

from seoro.lang.builtin_libraries import builtin_libraries
from seoro.lang.diagnostics import imports
from seoro.lang.frozen import Value
from seoro.lang.projects import settings_around
from seoro.lang.python_modules import module_path
from seoro.lang.source import SourceFile, Span

if TYPE_CHECKING:
    from seoro.lang.diagnostic import Diagnostic

Report: TypeAlias = "Callable[[Diagnostic], None]"

FOLDER = "seoro.libraries"  # beside the scenario file
ENTRY_POINTS = "seoro.libraries"  # the group of installed packages


class Origin(Enum):
    """Source of a library."""

    OWN = "seoro itself"
    BESIDE = "the folder beside the scenario"
    INSTALLED = "an installed package"
    PLUGIN = "an installed package for scenario_execution"


class Library(Value):
    """A library.

    Args:
        name: Imported name, such as `osc.nav2`.
        origin: Its source.
        path: The file with its declarations.
        shown: Name of that file in messages.
        module: The Python module that may implement it: its name in `FOLDER`, or that of the entry point; empty
            for built-in libraries and plugins.
        span: The first import.
    """

    name: str
    origin: Origin
    path: Path
    shown: str
    module: str
    span: Span


def find_library(name: str, span: Span, entry: SourceFile, report: Report) -> Library | None:
    """Find a library; report an unknown one and return None.

    Args:
        name: Imported name.
        span: The import.
        entry: The scenario file.
        report: Receives errors.
    """
    beside = _beside(name, entry)
    own = builtin_libraries().get(name)
    if own is not None:
        if beside is not None:
            report(imports.reserved_library(span, name, _shown(beside, entry)))
        return Library(name, Origin.OWN, own, f"<{name}>", "", span)
    bare = name.removeprefix("osc.")
    if beside is not None:
        return Library(name, Origin.BESIDE, beside, _shown(beside, entry), bare, span)
    return _installed(name, bare, span, entry, report)


def library_files(scenario: Path | None) -> dict[str, Path]:
    """Return the files of all libraries that a scenario can import, by imported name.

    Args:
        scenario: Its file; None for the libraries of all scenarios.
    """
    return {
        **_installed_files(),
        **(_files_beside(scenario) if scenario is not None else {}),
        **builtin_libraries(),
    }


def library_file(name: str, scenario: Path | None) -> Path | None:
    """Return the file of a library that a scenario can import; None if it is unknown."""
    return builtin_libraries().get(name) or library_files(scenario).get(name)


# ---------------------------------------------------------------- beside the scenario


def folder_of_libraries(scenario: Path) -> Path:
    """Return the folder of libraries beside a scenario file, or around the file of a library."""
    return folder_around(scenario) or scenario.absolute().parent / FOLDER


def library_folders(scenario: Path) -> tuple[Path, ...]:
    """Return the folders of libraries beside a scenario file and of its project, which may not exist.

    Raises:
        UsageError: The settings of the project are invalid.
    """
    return folder_of_libraries(scenario), *_folders_of_project(scenario)


def _folders_of_project(path: Path) -> tuple[Path, ...]:
    folders: tuple[Path, ...] = settings_around(path).get("libraries", ())
    return folders


def folder_around(path: Path) -> Path | None:
    """Return the folder of libraries that contains a file, or None."""
    full = path.absolute()
    own = next((folder for folder in full.parents[:2] if folder.name == FOLDER), None)
    return own or next((folder for folder in _folders_of_project(full) if folder in full.parents[:2]), None)


def _beside(name: str, entry: SourceFile) -> Path | None:
    """Return the file of a library in the folder beside a scenario file."""
    bare = name.removeprefix("osc.")
    if entry.path is None or "." in bare or bare == name:
        return None
    for folder in library_folders(entry.path):
        for path in (folder / f"{bare}.osc", folder / bare / f"{bare}.osc"):
            if path.is_file():
                return path
    return None


def _shown(path: Path, entry: SourceFile) -> str:
    """Return the name of a file beside the scenario, from the user's view."""
    assert entry.path is not None
    way = os.path.relpath(path, entry.path.absolute().parent)
    return os.path.normpath(Path(entry.name).parent / way)


def _files_beside(scenario: Path) -> dict[str, Path]:
    """Return the files of all libraries in the folder beside a scenario file, and in those of its project."""
    found: dict[str, Path] = {}
    for folder in reversed(library_folders(scenario)):
        packages = (path for path in folder.glob("*/*.osc") if path.stem == path.parent.name)
        found |= {f"osc.{path.stem}": path for path in (*packages, *folder.glob("*.osc"))}
    return found


# ---------------------------------------------------------------- installed packages


def _installed(name: str, bare: str, span: Span, entry: SourceFile, report: Report) -> Library | None:
    from importlib.metadata import entry_points  # noqa: PLC0415 - slow, and seldom needed

    points = entry_points(group=ENTRY_POINTS)
    modules = sorted({point.module for point in points if point.name == bare}) if bare != name else []
    if not modules:
        return _plugin(name, bare, span, entry, report)
    if len(modules) > 1:
        report(imports.ambiguous_library(span, name, tuple(modules)))
        return None
    origin = module_path(modules[0])
    if origin is None:
        report(imports.missing_module(span, name, modules[0]))
        return None
    return Library(name, Origin.INSTALLED, origin.parent / f"{bare}.osc", f"<{name}>", modules[0], span)


def _plugin(name: str, bare: str, span: Span, entry: SourceFile, report: Report) -> Library | None:
    """Find a library of a package for scenario_execution."""
    from seoro.lang.plugin_libraries import plugin_libraries, unbuilt_library  # noqa: PLC0415 - seldom needed

    found = {value: path for _, value, path in plugin_libraries(bare)} if bare != name else {}
    if not found:
        folder = unbuilt_library(bare, entry.path) if bare != name else None
        known = tuple(sorted(library_files(entry.path)))
        report(imports.unknown_module(span, name, known, str(folder) if folder is not None else ""))
        return None
    if len(found) > 1:
        report(imports.ambiguous_library(span, name, tuple(found)))
        return None
    [(value, path)] = found.items()
    if path is None:
        report(imports.missing_plugin_file(span, name, value))
        return None
    return Library(name, Origin.PLUGIN, path, f"<{name}>", "", span)


def _installed_files() -> dict[str, Path]:
    """Return the files of all libraries of installed packages."""
    from importlib.metadata import entry_points  # noqa: PLC0415 - slow, and seldom needed

    from seoro.lang.plugin_libraries import plugin_libraries  # noqa: PLC0415 - seldom needed

    found = ((point.name, module_path(point.module)) for point in entry_points(group=ENTRY_POINTS))
    return {
        **{f"osc.{name}": path for name, _, path in plugin_libraries() if path is not None},
        **{f"osc.{name}": origin.parent / f"{name}.osc" for name, origin in found if origin is not None},
    }

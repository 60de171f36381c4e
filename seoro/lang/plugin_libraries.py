"""Libraries of packages that were written for scenario_execution, found by their entry points.

The entry point `name = "package.module:function"` names a function that returns a package and the name of a file,
which is in the folder `lib_osc` of that package. The search for libraries runs no code: it reads the function, and
understands a `return` of two literals.
"""

from __future__ import annotations

import ast as python
import re
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.files.inputs import Kind, read_input
from seoro.lang.python_modules import module_spec

if TYPE_CHECKING:
    from importlib.metadata import EntryPoint

GROUP: Final = "scenario_execution.osc_libraries"
FOLDER: Final = "lib_osc"
_PROJECT_FILES: Final = ("pyproject.toml", "setup.py", "setup.cfg")
_PARENTS: Final = 4  # folders around a scenario that may be the root of its package


def plugin_libraries(name: str | None = None) -> Iterator[tuple[str, str, Path | None]]:
    """Yield the libraries of installed packages: name, entry point, and file; None for a missing file.

    Args:
        name: Name of the library, without `osc.`; None for all.
    """
    from importlib.metadata import entry_points  # noqa: PLC0415 - slow, and seldom needed

    points = {(point.name, point.value): point for point in entry_points(group=GROUP)}
    for (found, value), point in sorted(points.items()):
        if name in (None, found):
            yield found, value, _file(point)


def library_distributions(name: str) -> frozenset[str]:
    """Return the names of the installed distributions that have a library.

    Args:
        name: Name of the library, without `osc.`.
    """
    from importlib.metadata import entry_points  # noqa: PLC0415 - slow, and seldom needed

    points = entry_points(group=GROUP, name=name)
    return frozenset(point.dist.name for point in points if point.dist is not None)


def unbuilt_library(name: str, scenario: Path | None) -> Path | None:
    """Return the folder around a scenario whose package has a library, but may not be installed; or None.

    Args:
        name: Name of the library, without `osc.`.
        scenario: The scenario file.
    """
    if scenario is None:
        return None
    entry = re.compile(rf"^\W*{re.escape(name)}['\"]?\s*=", re.MULTILINE)
    for folder in scenario.absolute().parents[:_PARENTS]:
        for file in _PROJECT_FILES:
            try:
                text = read_input(folder / file, Kind.DEFINITION).decode(errors="replace")
            except OSError:
                continue
            if GROUP in text and entry.search(text):
                return folder
    return None


def unbuilt_package(name: str, scenario: Path | None) -> Path | None:
    """Return the folder around a scenario with the sources of a Python package; or None.

    Args:
        name: Name of the package.
        scenario: The scenario file.
    """
    for folder in scenario.absolute().parents[:_PARENTS] if scenario is not None else ():
        if (folder / name).is_dir() and any((folder / file).is_file() for file in _PROJECT_FILES):
            return folder
    return None


def _file(point: EntryPoint) -> Path | None:
    package, file = _returned(point) or (point.module.partition(".")[0], f"{point.name}.osc")
    spec = module_spec(package)
    for folder in (spec.submodule_search_locations or ()) if spec is not None else ():
        path = Path(folder) / FOLDER / file
        if path.is_file():
            return path
    return None


def _returned(point: EntryPoint) -> tuple[str, str] | None:
    """Return the two literals that the function of an entry point returns; None for any other function."""
    spec = module_spec(point.module)
    source = getattr(spec.loader, "get_source", None) if spec is not None else None
    try:
        tree = python.parse(source(point.module)) if source is not None else None
    except (ImportError, SyntaxError, OSError, TypeError, ValueError):
        return None
    for function in tree.body if tree is not None else ():
        if isinstance(function, python.FunctionDef) and function.name == point.attr:
            last = function.body[-1]
            try:
                value = python.literal_eval(last.value) if isinstance(last, python.Return) and last.value else None
            except ValueError:
                return None
            match value:
                case (str(package), str(file)):
                    return package, file
    return None

"""Import of the Python modules of libraries and external methods.

Modules in a folder beside a scenario are imported as parts of a synthetic package for that folder. So `sys.path`
is not changed, equal names in different folders do not clash, and modules use relative imports. Each module is
imported once per process.
"""

from __future__ import annotations

import importlib
import re
import sys
import traceback
from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path
from threading import Lock
from types import ModuleType
from typing import Final

import seoro.actions
from seoro.lang.frozen import Value
from seoro.lang.libraries import Library, Origin, folder_around

_PREFIX = "seoro_folder_"
_INVALIDATING: Final = Lock()  # Python's own function fails if two threads call it


class ImportFailed(Exception):
    """The import of a module failed.

    Args:
        module: Name of the module, for people.
        reason: Exception, in one line.
        hint: Suggestion for a fix; may be empty.
    """

    def __init__(self, module: str, reason: str, hint: str) -> None:
        super().__init__(f"{module}: {reason}")
        self.module = module
        self.reason = reason
        self.hint = hint


class Root(Value):
    """Folder of Python modules.

    Args:
        folder: The folder.
        package: Name of its package; empty for top-level modules.
    """

    folder: Path
    package: str


def root_of(library: Library) -> Root | None:
    """Return the folder of the module of a library; None for seoro's own libraries and plugins."""
    folder = library.path.parent
    match library.origin:
        case Origin.OWN | Origin.PLUGIN:
            return None
        case Origin.BESIDE:
            return root_of_folder(folder_around(library.path) or folder)
        case Origin.INSTALLED:
            package, _, last = library.module.rpartition(".")
            is_package = folder.name == last and (folder / "__init__.py").is_file()
            return Root(folder.parent if is_package else folder, package)


def root_of_folder(folder: Path) -> Root:
    """Make a package for a folder beside a scenario."""
    from hashlib import sha256  # noqa: PLC0415 - slow to load, and seldom needed

    resolved = folder.resolve()
    name = _PREFIX + sha256(str(resolved).encode()).hexdigest()[:16]
    if name not in sys.modules:
        package = ModuleType(name, f"The modules in {resolved}.")
        package.__path__ = [str(resolved)]
        sys.modules.setdefault(name, package)  # another thread may have been faster
    return Root(resolved, name)


def library_module(library: Library) -> ModuleType | None:
    """Import the Python module of a library, if any.

    Raises:
        ImportFailed: The import failed.
    """
    if library.origin is Origin.PLUGIN:
        return None
    bare = library.name.removeprefix("osc.")
    root = root_of(library)
    if root is None:
        name = f"{seoro.actions.__name__}.{bare}"
        return importlib.import_module(name) if "." not in bare and find_spec(name) is not None else None
    if library.origin is Origin.BESIDE and not is_module(root, [bare]):
        return None
    return import_beside(root, library.module.rpartition(".")[2])


def is_module(root: Root, parts: Sequence[str]) -> bool:
    """Return whether a folder has a module or package of a dotted name."""
    path = root.folder.joinpath(*parts)
    return path.with_name(f"{path.name}.py").is_file() or (path / "__init__.py").is_file()


def import_beside(root: Root, name: str) -> ModuleType:
    """Import a module of a folder.

    Raises:
        ImportFailed: The import failed.
    """
    with _INVALIDATING:
        importlib.invalidate_caches()  # the file may be newer than the cached listing of its folder
    try:
        return importlib.import_module(f"{root.package}.{name}" if root.package else name)
    except (Exception, SystemExit) as error:
        raise ImportFailed(name, reason_of(error, root.folder), _hint(error, root)) from error


def reason_of(error: BaseException, folder: Path | None = None) -> str:
    """Format an exception in one line, with the source line in a file of the folder."""
    lines = str(error).strip().splitlines()
    text = f"{type(error).__name__}: {lines[-1]}" if lines else type(error).__name__
    if folder is None or isinstance(error, SyntaxError):  # it has its own location
        return text
    frames = traceback.extract_tb(error.__traceback__)
    inside = [frame for frame in frames if Path(frame.filename).is_relative_to(folder)]
    return f"{text} ({Path(inside[-1].filename).name}, line {inside[-1].lineno})" if inside else text


def _hint(error: BaseException, root: Root) -> str:
    name = getattr(error, "name", None) if isinstance(error, ModuleNotFoundError) else None
    if name is None or not is_module(root, [name.partition(".")[0]]):
        return ""
    return f"use a relative import: `from .{name} import ...`"


def function_name(function: object) -> str:
    """Return the name of a function with its module, without the synthetic package."""
    module = getattr(function, "__module__", None)
    name = getattr(function, "__qualname__", type(function).__name__)
    return re.sub(rf"^{_PREFIX}\w+\.", "", f"{module}.{name}") if module else name

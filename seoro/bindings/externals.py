"""Finds the Python functions of external methods (7.3.7.4), and binds them.

The module of a dotted path is looked for beside the file of the declaration (for a library: beside its module),
and then among all that Python can import.
"""

from __future__ import annotations

import importlib

from seoro.bindings.modules import ImportFailed, Root, import_beside, is_module, reason_of, root_of, root_of_folder
from seoro.lang.check.checker import Checked
from seoro.lang.diagnostic import Bag, Message
from seoro.lang.diagnostics import bindings as messages
from seoro.lang.libraries import Library, Origin, folder_around
from seoro.lang.plan import External
from seoro.lang.source import SourceFile
from seoro.runtime.fitting import Fitting
from seoro.runtime.functions import bind_function
from seoro.runtime.signatures import Misfit


class _NotFound(Exception):
    """There is no such function.

    Args:
        message: What is wrong.
    """

    def __init__(self, message: Message) -> None:
        super().__init__(message)
        self.message = message


def bind_externals(checked: Checked, fitting: Fitting, is_own_only: bool, bag: Bag) -> None:
    """Give external methods their functions.

    Args:
        checked: The scenario, whose methods are given them.
        fitting: For the types.
        is_own_only: Whether to leave methods alone that seoro's own libraries do not declare.
        bag: For messages.
    """
    libraries = {library.name: library for library in checked.sources.libraries}
    homes = {module.file: module.library for module in checked.sources.modules}
    wrong = {found.primary.span.file for found in checked.errors}  # types may be unknown there
    for method, external in checked.program.methods.externals():
        file = external.span.file
        library = libraries.get(homes[file] or "")
        is_own = library is not None and library.origin is Origin.OWN
        if (is_own_only and not is_own) or "." not in external.path:  # that is reported already
            continue
        try:
            function = find_function(external, _root(file, library))
        except _NotFound as error:
            bag.add(error.message)
            continue
        if file in wrong:
            continue
        try:
            checked.program.methods.bind(external, bind_function(function, method, external, fitting))
        except Misfit as misfit:
            bag.add(messages.OtherArguments(external.span, external.path, method.name, str(misfit)))


def _root(file: SourceFile, library: Library | None) -> Root | None:
    """Where modules lie that the external methods of a file may name."""
    if library is not None:
        return root_of(library)
    return root_of_folder(folder_around(file.path) or file.path.parent) if file.path is not None else None


def find_function(external: External, root: Root | None) -> object:
    """The Python function at a dotted path: of a module, or of a class in one.

    Raises:
        _NotFound: There is none.
    """
    parts = external.path.split(".")
    found, length = _find_module(external, parts, root)
    for part in parts[length:]:
        if not hasattr(found, part):
            holder = ".".join(parts[:length])
            raise _NotFound(
                messages.NoPythonFunction(external.span, external.path, holder, part, tuple(dir(found)))
            )
        found = getattr(found, part)
        length += 1
    return found


def _find_module(external: External, parts: list[str], root: Root | None) -> tuple[object, int]:
    """The module that a path begins with, and how many parts of the path are its name."""
    lengths = range(len(parts) - 1, 0, -1)
    try:
        if root is not None:
            for length in lengths:
                if is_module(root, parts[:length]):
                    return import_beside(root, ".".join(parts[:length])), length
        for length in lengths:
            name = ".".join(parts[:length])
            found = _import(name)
            if found is not None:
                return found, length
    except ImportFailed as error:
        raise _NotFound(
            messages.BrokenFunction(external.span, external.path, error.module, error.reason, error.hint)
        ) from error
    raise _NotFound(messages.NoPythonModule(external.span, external.path, ".".join(parts[:-1])))


def _import(name: str) -> object | None:
    """A module that Python can import; None if there is none of that name."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and f"{name}.".startswith(f"{error.name}."):
            return None
        raise ImportFailed(name, reason_of(error), "") from error
    except (Exception, SystemExit) as error:
        raise ImportFailed(name, reason_of(error), "") from error

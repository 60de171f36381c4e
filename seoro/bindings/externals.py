"""Lookup and binding of the Python functions of external methods (7.3.7.4).

The module of a dotted path is searched beside the file of the declaration (for a library: beside its module), then
on `sys.path`.
"""

from __future__ import annotations

import importlib
from typing import TYPE_CHECKING

from seoro.bindings.imports import ImportFailed, Root, import_beside, is_module, reason_of, root_of, root_of_folder
from seoro.lang.builtin_libraries import builtin_libraries
from seoro.lang.diagnostic import Bag, Diagnostic
from seoro.lang.diagnostics import bindings as messages
from seoro.lang.libraries import Library, Origin, folder_around
from seoro.lang.plan import External, Methods
from seoro.lang.source import SourceFile
from seoro.runtime.functions.external import bind_function
from seoro.runtime.functions.fitting import Fitting
from seoro.runtime.functions.signatures import SignatureMismatch

if TYPE_CHECKING:
    from seoro.lang.check.checker import Checked


class _NotFound(Exception):
    """The function was not found.

    Args:
        message: Diagnostic.
    """

    def __init__(self, message: Diagnostic) -> None:
        super().__init__(message)
        self.message = message


def bind_externals(checked: Checked, fitting: Fitting, is_own_only: bool, bag: Bag) -> None:
    """Bind external methods to their functions.

    Args:
        checked: Scenario whose methods are bound.
        fitting: Conversion of types.
        is_own_only: Whether to bind only methods of seoro's own libraries.
        bag: Bag for diagnostics.
    """
    libraries = {library.name: library for library in checked.sources.libraries}
    library_names = {module.file: module.library for module in checked.sources.modules}
    wrong = {found.primary.span.file for found in checked.errors}  # types may be unknown there
    for method, external in checked.program.methods.externals():
        file = external.span.file
        library = libraries.get(library_names[file] or "")
        is_own = library is not None and library.origin is Origin.OWN
        if (is_own_only and not is_own) or "." not in external.path:  # that is reported already
            continue
        try:
            function = find_function(external, _root(file, library))
        except _NotFound as error:
            bag.put(error.message)
            continue
        if file in wrong:
            continue
        try:
            checked.program.methods.bind(external, bind_function(function, method, external, fitting))
        except SignatureMismatch as mismatch:
            bag.add(messages.method_signature_mismatch, external.span, external.path, method.name, str(mismatch))


def bind_own_externals(methods: Methods, fitting: Fitting) -> None:
    """Bind the external methods of seoro's own libraries to their functions.

    Raises:
        ValueError: A method is not declared in the text of a library.
        Exception: A function is missing, or does not match.
    """
    files = set(builtin_libraries().values())
    for method, external in methods.externals():
        span = external.span
        if span.file.path not in files or not span.text.startswith(f"external {external.path}("):
            raise ValueError(f"{external.path} is not declared in a library of seoro")
        function = find_function(external, None)
        methods.bind(external, bind_function(function, method, external, fitting))


def _root(file: SourceFile, library: Library | None) -> Root | None:
    """Return the folder of modules for the external methods of a file."""
    if library is not None:
        return root_of(library)
    return root_of_folder(folder_around(file.path) or file.path.parent) if file.path is not None else None


def find_function(external: External, root: Root | None) -> object:
    """Find the Python function at a dotted path, in a module or a class.

    Raises:
        _NotFound: The function is missing.
    """
    parts = external.path.split(".")
    found, start = _find_module(external, parts, root)
    for length, part in enumerate(parts[start:], start):
        if not hasattr(found, part):
            holder = ".".join(parts[:length])
            raise _NotFound(
                messages.missing_function(external.span, external.path, holder, part, tuple(dir(found)))
            )
        found = getattr(found, part)
    return found


def _find_module(external: External, parts: list[str], root: Root | None) -> tuple[object, int]:
    """Import the module at the start of a path; return it, and the number of parts of its name."""
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
            messages.broken_function(external.span, external.path, error.module, error.reason, error.hint)
        ) from error
    from seoro.lang.plugin_libraries import unbuilt_package  # noqa: PLC0415 - for this error only

    folder = unbuilt_package(parts[0], external.span.file.path)
    module = ".".join(parts[:-1])
    raise _NotFound(messages.missing_module(external.span, external.path, module, str(folder or "")))


def _import(name: str) -> object | None:
    """Import a module; return None if it does not exist."""
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError as error:
        if error.name is not None and f"{name}.".startswith(f"{error.name}."):
            return None
        raise ImportFailed(name, reason_of(error), "") from error
    except (Exception, SystemExit) as error:
        raise ImportFailed(name, reason_of(error), "") from error

"""Messages of imports (E0201 to E0206)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.diagnostics import listing, near
from seoro.lang.source import Span


def unknown_module(span: Span, name: str, candidates: tuple[str, ...], folder: str = "") -> Diagnostic:
    """An imported module that no library and no installed package provides; `folder` has it as source."""
    if folder:
        hint = f"`{folder}` has it for scenario_execution: install it beside seoro, with `pip install {folder}`"
        return error("E0201", span, f"library `{name}` not found", hint)
    hint = 'import a file by its name in quotes: `import "other.osc"`'
    if name.startswith("osc.") and candidates:
        hint = (
            f"seoro has the libraries {listing(candidates)}; others come with installed packages, or from a "
            "folder `seoro.libraries` beside the scenario"
        )
    return error("E0201", span, f"library `{name}` not found", near(name, candidates) or hint)


def missing_file(span: Span, path: str, reason: str, is_path: bool = False) -> Diagnostic:
    """An unreadable imported file."""
    hint = "paths are relative to the folder of the file that imports" if is_path else ""
    return error("E0202", span, f"cannot import `{path}`: {reason}", hint)


def unknown_scheme(span: Span, scheme: str) -> Diagnostic:
    """An import of a URI with an unsupported scheme."""
    return error("E0203", span, f"cannot import from `{scheme}:`", "use a path or a `file:` URI")


def reserved_library(span: Span, name: str, path: str) -> Diagnostic:
    """A library beside the scenario with the name of a library of seoro."""
    hint = "rename the file, and import it by its new name"
    return error("E0204", span, f"`{path}` cannot replace `{name}`, a library of seoro", hint)


def ambiguous_library(span: Span, name: str, modules: tuple[str, ...]) -> Diagnostic:
    """A library that several installed packages provide."""
    hint = "keep one of them, and uninstall the others"
    return error("E0205", span, f"several installed packages have a library `{name}`: {listing(modules)}", hint)


def missing_module(span: Span, name: str, module: str) -> Diagnostic:
    """A library of an installed package whose Python module is missing."""
    hint = "the entry point of its package names that module: correct it, or install the package again"
    return error("E0206", span, f"Python module `{module}` of the library `{name}` not found", hint)


def missing_plugin_file(span: Span, name: str, entry: str) -> Diagnostic:
    """A library of a package for scenario_execution whose file is missing."""
    hint = "the file must be in the folder `lib_osc` of the package that the function returns: install it again"
    return error("E0206", span, f"no file of the library `{name}` at its entry point `{entry}`", hint)

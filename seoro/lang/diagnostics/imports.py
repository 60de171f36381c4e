"""Messages of imports (E0201 to E0209)."""

from __future__ import annotations

from seoro.lang.diagnostic import Diagnostic, error
from seoro.lang.diagnostics import listing, near
from seoro.lang.frozen import Frozen
from seoro.lang.source import Span


class UnknownModule(Frozen):
    """An imported module that no library and no installed package provides."""

    span: Span
    name: str
    known: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = near(self.name, self.known)
        if not hint and not self.name.startswith("osc."):
            hint = 'a file is imported by its name in quotes: `import "other.osc"`'
        elif not hint:
            hint = (
                f"the known libraries are {listing(self.known)}; others come with installed packages, or from "
                "a folder `seoro.libraries` beside the scenario"
            )
        return error("E0201", self.span, f"no library `{self.name}` is installed", help=hint)


class MissingFile(Frozen):
    """An imported file that cannot be read."""

    span: Span
    path: str
    reason: str
    is_path: bool = False

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "paths are relative to the folder of the file that imports" if self.is_path else ""
        return error("E0202", self.span, f"cannot import `{self.path}`: {self.reason}", help=hint)


class UnknownScheme(Frozen):
    """An import of a URI that is no file."""

    span: Span
    scheme: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "only `file:` URIs and paths can be imported"
        return error("E0203", self.span, f"cannot import from `{self.scheme}:`", help=hint)


class OwnName(Frozen):
    """A library in the folder beside the scenario that has the name of one of seoro's own."""

    span: Span
    name: str
    path: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"`{self.name}` is a library of seoro's own, which `{self.path}` cannot replace"
        return error("E0204", self.span, text, help="give the file another name, and import it by that")


class AmbiguousLibrary(Frozen):
    """A library that several installed packages provide."""

    span: Span
    name: str
    modules: tuple[str, ...]

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"several installed packages have a library `{self.name}`: {listing(self.modules)}"
        return error("E0205", self.span, text, help="uninstall all of them but one")


class NoModule(Frozen):
    """A library of an installed package whose Python module is not there."""

    span: Span
    name: str
    module: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        text = f"the library `{self.name}` belongs to the Python module `{self.module}`, which there is not"
        hint = "the entry point of its package names that module: correct it, or install the package again"
        return error("E0206", self.span, text, help=hint)

"""Messages of imports (E020 to E0209)."""

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
            hint = f"the known libraries are {listing(self.known)}; others come with installed packages"
        return error("E0201", self.span, f"no library `{self.name}` is installed", help=hint)


class MissingFile(Frozen):
    """An imported file that cannot be read."""

    span: Span
    path: str
    reason: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        return error("E0202", self.span, f"cannot import `{self.path}`: {self.reason}")


class UnknownScheme(Frozen):
    """An import of a URI that is no file."""

    span: Span
    scheme: str

    def diagnostic(self) -> Diagnostic:
        """The message."""
        hint = "only `file:` URIs and paths can be imported"
        return error("E0203", self.span, f"cannot import from `{self.scheme}:`", help=hint)

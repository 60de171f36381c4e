"""Messages of imports (E0201 to E0206)."""

from __future__ import annotations

from seoro.lang.diagnostics.template import TemplateMessage


class UnknownModule(TemplateMessage):
    """An imported module that no library and no installed package provides."""

    CODE = "E0201"
    TEXT = "library `{name}` not found"
    HELP = (
        "{near}",
        "{_is_own:if}seoro has the libraries {candidates:and}; others come with installed packages, or from a "
        "folder `seoro.libraries` beside the scenario",
        'import a file by its name in quotes: `import "other.osc"`',
    )

    name: str
    candidates: tuple[str, ...]

    @property
    def _is_own(self) -> bool:
        return self.name.startswith("osc.")


class MissingFile(TemplateMessage):
    """An unreadable imported file."""

    CODE = "E0202"
    TEXT = "cannot import `{path}`: {reason}"
    HELP = ("{is_path:if}paths are relative to the folder of the file that imports",)

    path: str
    reason: str
    is_path: bool = False


class UnknownScheme(TemplateMessage):
    """An import of a URI with an unsupported scheme."""

    CODE = "E0203"
    TEXT = "cannot import from `{scheme}:`"
    HELP = "use a path or a `file:` URI"

    scheme: str


class ReservedLibrary(TemplateMessage):
    """A library beside the scenario with the name of a library of seoro."""

    CODE = "E0204"
    TEXT = "`{path}` cannot replace `{name}`, a library of seoro"
    HELP = "rename the file, and import it by its new name"

    name: str
    path: str


class AmbiguousLibrary(TemplateMessage):
    """A library that several installed packages provide."""

    CODE = "E0205"
    TEXT = "several installed packages have a library `{name}`: {modules:and}"
    HELP = "keep one of them, and uninstall the others"

    name: str
    modules: tuple[str, ...]


class MissingModule(TemplateMessage):
    """A library of an installed package whose Python module is missing."""

    CODE = "E0206"
    TEXT = "Python module `{module}` of the library `{name}` not found"
    HELP = "the entry point of its package names that module: correct it, or install the package again"

    name: str
    module: str

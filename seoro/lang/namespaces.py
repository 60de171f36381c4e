"""Namespaces: scopes of declarations, and exported names (7.7.4)."""

from __future__ import annotations

from seoro.lang import ast
from seoro.lang.frozen import Value
from seoro.lang.source import Span

GLOBAL_NAMESPACE = "null"


class Space(Value):
    """The scope of a namespace statement, which names without a prefix are searched in (7.7.4.2)."""

    name: str
    uses: frozenset[str] = frozenset()


class Home(Value):
    """Namespace and library of a declaration.

    Args:
        space: The scope of its text.
        library: Imported library, such as `osc.nav2`; None for files of the user.
    """

    space: Space
    library: str | None

    def namespace_of(self, name: ast.Name) -> str:
        """Return the namespace of a name that is declared here: its prefix, else the current namespace."""
        return name.namespace or self.space.name


class Export(Value):
    """An item of an export list: a name, or all names of a namespace (7.7.4.1)."""

    namespace: str | None  # None if the name has no prefix
    name: str | None  # None for all names
    home: Home
    span: Span

"""Python that a scenario brings itself, besides that of installed packages."""

from __future__ import annotations

from collections.abc import Iterator

from seoro.bindings.imports import is_module, root_of
from seoro.lang import ast
from seoro.lang.libraries import Origin
from seoro.lang.loader import Sources
from seoro.lang.source import Span
from seoro.lang.tree import find


def own_python(sources: Sources) -> Iterator[tuple[Span, str]]:
    """Yield the places where the files of a scenario contain or name Python, each with a description."""
    trusted = {library.name for library in sources.libraries if library.origin is not Origin.BESIDE}
    for library in sources.libraries:
        root = root_of(library) if library.origin is Origin.BESIDE else None
        if root is not None and is_module(root, [library.module]):
            yield library.span, f"the library `{library.name}` contains Python"
    for module in sources.modules:
        if module.library not in trusted:
            for method in find(module.tree, ast.ExternalMethod):
                yield method.span, "an external method calls Python"

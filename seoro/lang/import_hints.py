"""Hints for names whose import is missing: the built-in library that declares them."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache

from seoro.lang.builtin_libraries import STANDARD_MODULES, builtin_libraries

TYPES = ("type", "enum", "struct", "actor")
BEHAVIORS = ("action", "scenario")
MODIFIERS = ("modifier",)


def import_hint(name: str, kinds: Iterable[str], owner: str | None = None) -> str:
    """Suggest the import of the built-in library that declares a name; empty without such a library.

    Args:
        name: The unknown name.
        kinds: Keywords of the declarations to search for.
        owner: Actor of the declarations, if any.
    """
    for library, declared in _declarations().items():
        if any((kind, owner or "", name) in declared for kind in kinds):
            return f"add `import {library}`"
    return ""


@cache
def _declarations() -> dict[str, frozenset[tuple[str, str, str]]]:
    """Kind, actor and name of all declarations of each library, by the name to import."""
    declaration = re.compile(rf"^({'|'.join((*TYPES, *BEHAVIORS, *MODIFIERS))}) (?:(\w+)\.)?(\w+)", re.MULTILINE)
    found = {}
    for library, path in builtin_libraries().items():
        if library == "osc.types" or library not in STANDARD_MODULES:
            found[library] = frozenset(declaration.findall(path.read_text(encoding="utf-8")))
    return found

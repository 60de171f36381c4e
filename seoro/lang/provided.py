"""Which library of seoro's own declares a name: for messages about names whose import is missing."""

from __future__ import annotations

import re
from collections.abc import Iterable
from functools import cache

from seoro.lang.libraries import STANDARD_MODULES, own_libraries

TYPES = ("type", "enum", "struct", "actor")
BEHAVIORS = ("action", "scenario")
MODIFIERS = ("modifier",)


def import_hint(name: str, kinds: Iterable[str], owner: str | None = None) -> str:
    """The import statement that provides a name; empty if no library does.

    Args:
        name: The unknown name.
        kinds: The keywords of the declarations to look for.
        owner: The actor that the declarations belong to, if any.
    """
    for library, declared in _declarations().items():
        if any((kind, owner or "", name) in declared for kind in kinds):
            return f"it comes with `import {library}`"
    return ""


@cache
def _declarations() -> dict[str, frozenset[tuple[str, str, str]]]:
    """The kind, actor and name of what each library declares, by the name to import."""
    declaration = re.compile(rf"^({'|'.join((*TYPES, *BEHAVIORS, *MODIFIERS))}) (?:(\w+)\.)?(\w+)", re.MULTILINE)
    found = {}
    for library, path in own_libraries().items():
        if library == "osc.types" or library not in STANDARD_MODULES:
            found[library] = frozenset(declaration.findall(path.read_text(encoding="utf-8")))
    return found

"""Built-in libraries: the files in `library/`, by the names to import, and hints for missing imports."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path
from typing import Final

_FOLDER: Final = Path(__file__).with_name("library")

STANDARD_MODULES: Final[Mapping[str, tuple[str, frozenset[str]]]] = {
    "osc.types": ("types.osc", frozenset({"stdtypes"})),
    "osc.standard": ("standard.osc", frozenset({"std", "stdtypes"})),
    "osc.standard.all": ("standard.osc", frozenset()),
    "osc.standard.types": ("types.osc", frozenset()),
}
"""Modules whose file has another name, with the namespaces that they use."""


def builtin_libraries() -> dict[str, Path]:
    """Return the files of the built-in libraries by the names to import."""
    found = {f"osc.{path.stem}": path for path in sorted(_FOLDER.glob("*.osc"))}
    return {**found, **{name: _FOLDER / file for name, (file, _) in STANDARD_MODULES.items()}}


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

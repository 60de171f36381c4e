"""Built-in libraries: the files in `library/`, by the names to import."""

from __future__ import annotations

from collections.abc import Mapping
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

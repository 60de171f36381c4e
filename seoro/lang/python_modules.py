"""Search for Python modules without running them or their packages."""

from __future__ import annotations

from importlib.machinery import PathFinder
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from importlib.machinery import ModuleSpec
    from pathlib import Path


def module_spec(module: str) -> ModuleSpec | None:
    """Find a Python module by its dotted name; return None if it is missing."""
    from importlib.util import find_spec  # noqa: PLC0415 - seldom needed

    top, *rest = module.split(".")
    try:
        spec: ModuleSpec | None = find_spec(top)
    except (ImportError, ValueError):
        return None
    name = top
    for part in rest:
        if spec is None or spec.submodule_search_locations is None:
            return None
        name = f"{name}.{part}"
        spec = PathFinder.find_spec(name, spec.submodule_search_locations)
    return spec


def module_path(module: str) -> Path | None:
    """Find the file of a Python module."""
    from pathlib import Path  # noqa: PLC0415 - seldom needed

    spec = module_spec(module)
    return Path(spec.origin) if spec is not None and spec.has_location and spec.origin is not None else None

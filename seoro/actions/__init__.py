"""What seoro's own libraries do: one module for each `.osc` file in `seoro.lang.library` with actions.

They are written against the contracts of the runtime, so that where an actor lives decides how an action is
carried out. Libraries of installed packages come from the entry-point group `seoro.libraries`.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from importlib import import_module
from importlib.util import find_spec
from types import ModuleType

from seoro.lang.loader import ENTRY_POINTS, own_libraries


def modules_of(libraries: Iterable[str]) -> Iterator[ModuleType]:
    """The Python modules that implement libraries.

    Args:
        libraries: As they were imported, such as `osc.nav2`.
    """
    for library in libraries:
        name = library.removeprefix("osc.")
        own = f"{__name__}.{name}"
        if library in own_libraries():
            if "." not in name and find_spec(own) is not None:
                yield import_module(own)
            continue
        from importlib.metadata import entry_points  # noqa: PLC0415 - slow to load, and seldom needed

        for entry in entry_points(group=ENTRY_POINTS, name=name):
            yield import_module(entry.module)

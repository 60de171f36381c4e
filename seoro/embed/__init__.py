"""Loading and running scenarios from Python.

    scenario = seoro.load("maze.osc")
    async with seoro.start(scenario, seed=7) as run:
        async for record in run.trace():
            ...
    result = await run.result()

A run lives in the caller's event loop, in its own task group. It installs no signal handlers and changes no global
logging. If the caller is cancelled, it cleans up and leaves nothing behind. `run` is for scripts without an event
loop.

Names are loaded on first use, so that programs that only check or send scenarios do not load the runtime.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from seoro.lazy_names import lazy_names

if TYPE_CHECKING:
    from seoro.embed.api import accept, replay, run, start
    from seoro.embed.options import SEED_BITS
    from seoro.embed.preparation import announcement, prepare
    from seoro.embed.scenarios import Scenario, check_file, load

__all__ = [
    "SEED_BITS",
    "Scenario",
    "accept",
    "announcement",
    "check_file",
    "load",
    "prepare",
    "replay",
    "run",
    "start",
]

_MODULES = {
    "seoro.embed.options": ("SEED_BITS",),
    "seoro.embed.preparation": ("announcement", "prepare"),
    "seoro.embed.scenarios": ("Scenario", "check_file", "load"),
    "seoro.embed.api": ("accept", "replay", "run", "start"),
}


if not TYPE_CHECKING:  # type checkers report unknown names
    __getattr__ = lazy_names(__name__, _MODULES)

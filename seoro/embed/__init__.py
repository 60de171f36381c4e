"""Loading and running scenarios from Python.

    scenario = seoro.load("maze.osc")
    async with seoro.start(scenario, seed=7) as run:
        async for record in run.trace():
            ...
    result = await run.result()

A run lives inside of the caller's event loop, in a task group of its own. It installs no signal handlers, touches
no global logging, and when the caller is cancelled it cleans up and leaves nothing behind. `run` is for scripts
that have no event loop.

Names are loaded when they are first used: whoever checks a scenario, or has it run elsewhere, loads nothing of
what runs one here.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seoro.embed.scenarios import Scenario, check_file, load
    from seoro.embed.starting import SEED_BITS, accept, announcement, prepare, run, start

__all__ = ["SEED_BITS", "Scenario", "accept", "announcement", "check_file", "load", "prepare", "run", "start"]

_MODULES = {
    "seoro.embed.scenarios": ("Scenario", "check_file", "load"),
    "seoro.embed.starting": ("SEED_BITS", "accept", "announcement", "prepare", "run", "start"),
}


def __getattr__(name: str) -> Any:
    for module, names in _MODULES.items():
        if name in names:
            return getattr(import_module(module), name)
    raise AttributeError(f"module 'seoro.embed' has no attribute {name!r}")

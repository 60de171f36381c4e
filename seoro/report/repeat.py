"""Command that repeats a run."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

from seoro.traces.reader import Record


def repeat_command(start: Record, scene: Mapping[str, Any]) -> str:
    """Return the command line of `seoro exec` that repeats a run.

    Args:
        start: Record `run.start`.
        scene: Simulator and world: the record `scene`, or fields `simulator` and `world`.
    """
    words = ["seoro", "exec", str(start["file"]), "--scenario", str(start["scenario"])]
    if isinstance(start.get("seed"), int):
        words += ["--seed", str(start["seed"])]
    simulator, world = scene.get("simulator"), scene.get("world")
    if isinstance(simulator, str) and simulator:
        words += ["--sim", simulator]
        words += ["--world", world] if isinstance(world, str) and world else []
        rate = start.get("rate")
        words += ["--rate", f"{rate:g}" if isinstance(rate, int | float) else "max"]
    elif isinstance(start.get("clock"), str):
        words += ["--clock", start["clock"]]
    overrides = start.get("overrides")
    for name, value in overrides.items() if isinstance(overrides, dict) else ():
        words += ["--set", f"{name}={value}"]
    constraints = start.get("constraints")
    for text in constraints if isinstance(constraints, list) else ():
        words += ["--constrain", str(text)]
    return shlex.join(words)

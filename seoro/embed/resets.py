"""Scenarios by which a lab leaves its robots in order, which are loaded before the run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from seoro.embed.opening import actors_of
from seoro.embed.options import Options
from seoro.embed.scenarios import load
from seoro.errors import InvalidUse
from seoro.lab.resetting import Reset
from seoro.lang.frontend import lower


def resets_of(options: Options) -> Callable[[Path, str], Reset]:
    """What loads them for a run, each once.

    Args:
        options: Of the run.
    """
    loaded: dict[Path, Reset] = {}

    def reset_of(path: Path, place: str) -> Reset:
        if path not in loaded:
            loaded[path] = _load(path, options)
        reset = loaded[path]
        if len(reset.actors) != 1:
            actors = ", ".join(reset.actors) or "none"
            raise InvalidUse(
                f"{place}: the scenario {reset.plan.entry} of {path} has to have one actor, which the robot is; "
                f"it has {actors}"
            )
        return reset

    return reset_of


def _load(path: Path, options: Options) -> Reset:
    scenario = (options.load or load)(path)
    plan = lower(scenario.checked, None, {})
    if options.vet is not None:
        options.vet(plan)
    return Reset(plan, scenario.functions, tuple(sorted(actors_of(plan))))

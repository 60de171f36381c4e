"""Reset scenarios of a lab for its robots after a run, loaded before the run."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from seoro.embed.backends import actor_names
from seoro.embed.options import Options
from seoro.embed.scenarios import load
from seoro.errors import UsageError
from seoro.lab.resetting import Reset
from seoro.lang.frontend import lower


def resets_of(options: Options) -> Callable[[Path, str], Reset]:
    """Make a function that loads reset scenarios, each once.

    Args:
        options: Options of the run.
    """
    loaded: dict[Path, Reset] = {}

    def reset_of(path: Path, place: str) -> Reset:
        if path not in loaded:
            loaded[path] = _load(path, options)
        reset = loaded[path]
        if len(reset.actors) != 1:
            actors = ", ".join(reset.actors) or "none"
            raise UsageError(
                f"{place}: the reset scenario {reset.plan.entry} in {path} must have exactly one actor, the robot "
                f"(found {actors})"
            )
        return reset

    return reset_of


def _load(path: Path, options: Options) -> Reset:
    scenario = (options.load or load)(path)
    plan = lower(scenario.checked, None, {})
    if options.vet is not None:
        options.vet(plan)
    return Reset(plan, scenario.functions, tuple(sorted(actor_names(plan))))

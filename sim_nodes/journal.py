"""The calls by which a deterministic engine has come to its state, so that they can be made again.

It is the way to save engines that cannot put all of their state back: the same calls lead to the same state. Going
back takes as long as the steps took.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import wraps
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar

import numpy as np

from sim_nodes.physics import UnsavableState

MAX_CALLS = 500_000  # more than five hours of a robot that drives, and 100 MB
MARK = "is_journaled"

P = ParamSpec("P")
R = TypeVar("R")


class Journal:
    """The calls of one engine since its scene was built or reset, each with the number of steps before it."""

    def __init__(self) -> None:
        self._steps = 0
        self._calls: list[tuple[int, str, tuple[Any, ...]]] = []
        self._is_full = False

    def step(self, count: int) -> None:
        """Note that steps were made."""
        self._steps += count

    def note(self, method: str, arguments: tuple[Any, ...]) -> None:
        """Note a call; when there are too many, none is kept."""
        if len(self._calls) >= MAX_CALLS:
            self._is_full = True
            self._calls.clear()
        if not self._is_full:
            kept = tuple(each.copy() if isinstance(each, np.ndarray) else each for each in arguments)
            self._calls.append((self._steps, method, kept))

    def save(self) -> Mapping[str, Any]:
        """All calls.

        Raises:
            UnsavableState: There were too many.
        """
        if self._is_full:
            raise UnsavableState(
                "what this engine was told is saved, not what it came to, and since its last reset it was told "
                f"more than the {MAX_CALLS} things that are kept: save earlier, or reset it"
            )
        return {"steps": self._steps, "calls": self._calls}


class Journaling(Protocol):
    """An engine with a journal."""

    journal: Journal


J = TypeVar("J", bound=Journaling)


def journaled(method: Callable[Concatenate[J, P], R]) -> Callable[Concatenate[J, P], R]:
    """A method that changes what its engine simulates: its calls stand in the journal, unless they fail."""
    name = method.__name__

    @wraps(method)
    def call(engine: J, /, *arguments: P.args, **named: P.kwargs) -> R:
        assert not named, f"{name} is called by position, since the journal has no names"
        result = method(engine, *arguments, **named)
        engine.journal.note(name, arguments)
        return result

    setattr(call, MARK, True)
    return call


def replay(saved: Mapping[str, Any], engine: Journaling, step: Callable[[int], int]) -> None:
    """Make the calls of another engine again; they stand in the journal of this one then.

    Args:
        saved: What `Journal.save` returned.
        engine: The engine; its scene has just been built, and its journal is empty.
        step: Makes up to a number of steps; returns how many.

    Raises:
        UnsavableState: There are calls that are none of this engine.
    """
    made = 0
    for steps, name, arguments in saved["calls"]:
        method = getattr(type(engine), name, None)
        if not getattr(method, MARK, False):
            raise UnsavableState(f"{name!r} is nothing that this engine can be told")
        while made < steps:
            made += step(steps - made)
        getattr(engine, name)(*arguments)
    while made < saved["steps"]:
        made += step(saved["steps"] - made)

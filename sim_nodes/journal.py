"""The calls by which a deterministic engine has come to its state, so that they can be made again.

It is the way to save engines that cannot put all of their state back: the same calls lead to the same state. Going
back takes as long as the steps took.

Nearly all calls are commands to motors, the same with other numbers. So a call is kept as its kind, which is the
method with all arguments but numbers, and its numbers stand in one row with those of all others.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import wraps
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar

import numpy as np

from sim_nodes.physics import UnsavableState

MAX_CALLS = 2_000_000
MAX_NUMBERS = 6_000_000  # 48 MB, which a message still holds
MARK = "is_journaled"
NUMBER = 0  # stands for a number; a row of them is its length, and any other argument is itself, in a tuple

P = ParamSpec("P")
R = TypeVar("R")
Slot = int | tuple[Any]
Kind = tuple[str, tuple[Slot, ...]]


class Calls:
    """Calls, each with the number of steps before it."""

    def __init__(self) -> None:
        self._kinds: list[Kind] = []
        self._known: dict[Kind, int] = {}  # the indices of those that others may be of, too
        self._steps = array("Q")
        self._kind = array("Q")  # of each call
        self._numbers = array("d")

    @property
    def is_full(self) -> bool:
        """Whether there are more than can be saved."""
        return len(self._steps) > MAX_CALLS or len(self._numbers) > MAX_NUMBERS

    def add(self, steps: int, method: str, arguments: tuple[Any, ...]) -> None:
        """Add a call."""
        self._steps.append(steps)
        self._kind.append(self._index((method, tuple(map(_slot, arguments)))))
        for argument in arguments:
            if isinstance(argument, float):
                self._numbers.append(argument)
            elif isinstance(argument, np.ndarray):
                self._numbers.extend(argument)

    def _index(self, kind: Kind) -> int:
        # Places and models hold numbers, too; those that compare as equal may differ in their bits, as zeros do.
        is_plain = all(isinstance(slot, int) or isinstance(slot[0], str | bool) for slot in kind[1])
        index = self._known.get(kind) if is_plain else None
        if index is None:
            index = len(self._kinds)
            self._kinds.append(kind)
            if is_plain:
                self._known[kind] = index
        return index

    @property
    def mark(self) -> tuple[int, int, int]:
        """How many calls, kinds and numbers there are."""
        return len(self._steps), len(self._kinds), len(self._numbers)

    def cut(self, mark: tuple[int, int, int]) -> None:
        """Forget the calls since a mark."""
        calls, kinds, numbers = mark
        del self._steps[calls:], self._kind[calls:], self._kinds[kinds:], self._numbers[numbers:]
        self._known = {kind: index for kind, index in self._known.items() if index < kinds}

    def save(self) -> Mapping[str, Any]:
        """All of them as data, of which little is left when it is compressed but the numbers."""
        return {
            "kinds": list(self._kinds),
            "steps_between": np.diff(np.array(self._steps), prepend=np.uint64(0)),
            "kind": np.array(self._kind).astype(np.uint32),
            "numbers": np.array(self._numbers),
        }


def calls_of(saved: Mapping[str, Any]) -> Iterator[tuple[int, str, tuple[Any, ...]]]:
    """The calls in what `Calls.save` returned: the number of steps before each, the method and its arguments."""
    numbers, place = saved["numbers"], 0
    for steps, index in zip(np.cumsum(saved["steps_between"], dtype=np.uint64), saved["kind"], strict=True):
        method, slots = saved["kinds"][index]
        arguments: list[Any] = []
        for slot in slots:
            if isinstance(slot, tuple):
                arguments.append(slot[0])
            elif slot == NUMBER:
                arguments.append(float(numbers[place]))
                place += 1
            else:
                arguments.append(numbers[place : place + slot].copy())
                place += slot
        yield int(steps), method, tuple(arguments)


def _slot(argument: Any) -> Slot:
    if isinstance(argument, float):
        return NUMBER
    return len(argument) if isinstance(argument, np.ndarray) else (argument,)


@dataclass(frozen=True)
class Mark:
    """A place in a journal: the number of steps, the calls, and how many of them."""

    steps: int
    calls: Calls
    size: tuple[int, int, int]


class Journal:
    """The calls of one engine since its scene was built or reset.

    Arrays among their arguments are rows of numbers, at least of one.
    """

    def __init__(self) -> None:
        self._steps = 0
        self._calls: Calls | None = Calls()  # None when there were too many

    def step(self, count: int) -> None:
        """Note that steps were made."""
        self._steps += count

    def note(self, method: str, arguments: tuple[Any, ...]) -> None:
        """Note a call; when there are too many, none is kept."""
        if self._calls is not None:
            self._calls.add(self._steps, method, arguments)
            if self._calls.is_full:
                self._calls = None

    def mark(self) -> Mark | None:
        """Where it is now; None when there were too many calls."""
        return None if self._calls is None else Mark(self._steps, self._calls, self._calls.mark)

    def cut(self, mark: Mark) -> None:
        """Forget what was noted since a mark."""
        self._steps, self._calls = mark.steps, mark.calls
        mark.calls.cut(mark.size)

    def save(self) -> Mapping[str, Any]:
        """All calls.

        Raises:
            UnsavableState: There were too many.
        """
        if self._calls is None:
            raise UnsavableState(
                "what this engine was told is saved, not what it came to, and since its last reset it was told "
                f"more than is kept ({MAX_CALLS} things, {MAX_NUMBERS} numbers): save earlier, or reset it"
            )
        return {"steps": self._steps, **self._calls.save()}


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
    for steps, name, arguments in calls_of(saved):
        method = getattr(type(engine), name, None)
        if not getattr(method, MARK, False):
            raise UnsavableState(f"{name!r} is nothing that this engine can be told")
        while made < steps:
            made += step(steps - made)
        getattr(engine, name)(*arguments)
    while made < saved["steps"]:
        made += step(saved["steps"] - made)

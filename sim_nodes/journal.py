"""Journal of the calls of a deterministic engine, to reach its state by replay.

This saves the state of engines that cannot export all of it: equal calls lead to equal states. A restore takes as
long as the steps took.

Nearly all calls are motor commands that differ only in numbers. So a call is stored as its kind, the method and
all other arguments, and its numbers are in one array with those of all calls.
"""

from __future__ import annotations

from array import array
from collections.abc import Callable, Iterator, Mapping
from functools import wraps
from typing import Any, Concatenate, ParamSpec, Protocol, TypeVar

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.physics import UnsavableState

MAX_CALLS = 2_000_000
MAX_NUMBERS = 6_000_000  # 48 MB, within the limit of a message
MARK = "is_journaled"
NUMBER = 0  # placeholder of a number; a row of numbers is its length, any other argument is itself in a tuple

P = ParamSpec("P")
R = TypeVar("R")
Slot = int | tuple[Any]
CallKind = tuple[str, tuple[Slot, ...]]


def calls_of(saved: Mapping[str, Any]) -> Iterator[tuple[int, str, tuple[Any, ...]]]:
    """Yield the calls saved by `Journal.save`: the number of preceding steps, the method and its arguments."""
    numbers, position = saved["numbers"], 0
    for steps, index in zip(np.cumsum(saved["steps_between"], dtype=np.uint64), saved["kind"], strict=True):
        method, slots = saved["kinds"][index]
        arguments: list[Any] = []
        for slot in slots:
            if isinstance(slot, tuple):
                arguments.append(slot[0])
            elif slot == NUMBER:
                arguments.append(float(numbers[position]))
                position += 1
            else:
                arguments.append(numbers[position : position + slot].copy())
                position += slot
        yield int(steps), method, tuple(arguments)


def _slot(argument: Any) -> Slot:
    if isinstance(argument, float):
        return NUMBER
    return len(argument) if isinstance(argument, np.ndarray) else (argument,)


@dataclass(frozen=True)
class Mark:
    """A position in a journal: the number of steps, and the sizes of its rows."""

    steps: int
    calls: int
    kinds: int
    numbers: int


class Journal:
    """The calls of one engine since its scene was built or reset, each with the number of preceding steps.

    Arrays among the arguments are non-empty rows of numbers.
    """

    def __init__(self) -> None:
        self._made = 0  # steps
        self._kinds: list[CallKind] = []
        self._known: dict[CallKind, int] = {}  # indices of kinds that later calls may share
        self._steps = array("Q")
        self._kind = array("Q")  # of each call
        self._numbers = array("d")

    @property
    def _is_full(self) -> bool:
        """Whether there are more calls than can be saved."""
        return len(self._steps) > MAX_CALLS or len(self._numbers) > MAX_NUMBERS

    def step(self, count: int) -> None:
        """Record steps."""
        self._made += count

    def record(self, method: str, arguments: tuple[Any, ...]) -> None:
        """Record a call; after too many calls, no further ones."""
        if self._is_full:
            return
        self._steps.append(self._made)
        self._kind.append(self._index((method, tuple(map(_slot, arguments)))))
        for argument in arguments:
            if isinstance(argument, float):
                self._numbers.append(argument)
            elif isinstance(argument, np.ndarray):
                self._numbers.extend(argument)

    def _index(self, kind: CallKind) -> int:
        # Poses and models contain numbers, too; equal values may differ in their bits, as zeros do.
        is_plain = all(isinstance(slot, int) or isinstance(slot[0], str | bool) for slot in kind[1])
        index = self._known.get(kind) if is_plain else None
        if index is None:
            index = len(self._kinds)
            self._kinds.append(kind)
            if is_plain:
                self._known[kind] = index
        return index

    def mark(self) -> Mark | None:
        """Return the present position; None after too many calls."""
        if self._is_full:
            return None
        return Mark(self._made, len(self._steps), len(self._kinds), len(self._numbers))

    def cut(self, mark: Mark) -> None:
        """Remove the calls since a mark."""
        self._made = mark.steps
        del self._steps[mark.calls :], self._kind[mark.calls :]
        del self._kinds[mark.kinds :], self._numbers[mark.numbers :]
        self._known = {kind: index for kind, index in self._known.items() if index < mark.kinds}

    def save(self) -> Mapping[str, Any]:
        """Return all calls as data; compressed, little remains but the numbers.

        Raises:
            UnsavableState: There were too many.
        """
        if self._is_full:
            raise UnsavableState(
                "this engine saves its calls since the last reset, and there are more "
                f"than the limit ({MAX_CALLS} calls, {MAX_NUMBERS} numbers): save earlier, or reset it"
            )
        return {
            "steps": self._made,
            "kinds": list(self._kinds),
            "steps_between": np.diff(np.array(self._steps), prepend=np.uint64(0)),
            "kind": np.array(self._kind).astype(np.uint32),
            "numbers": np.array(self._numbers),
        }


class Journaling(Protocol):
    """An engine with a journal."""

    journal: Journal


J = TypeVar("J", bound=Journaling)


def journaled(method: Callable[Concatenate[J, P], R]) -> Callable[Concatenate[J, P], R]:
    """Decorate a method that changes the simulated state: successful calls are recorded in the journal."""
    name = method.__name__

    @wraps(method)
    def call(engine: J, /, *arguments: P.args, **named: P.kwargs) -> R:
        assert not named, f"{name} takes positional arguments only, for the journal"
        result = method(engine, *arguments, **named)
        engine.journal.record(name, arguments)
        return result

    setattr(call, MARK, True)
    return call


def replay(saved: Mapping[str, Any], engine: Journaling, step: Callable[[int], int]) -> None:
    """Replay the calls of another engine, and record them in the journal of this one.

    Args:
        saved: Result of `Journal.save`.
        engine: The engine; its scene has just been built, and its journal is empty.
        step: Makes up to a number of steps; returns how many.

    Raises:
        UnsavableState: A call is unknown to this engine.
    """
    made = 0
    for steps, name, arguments in calls_of(saved):
        method = getattr(type(engine), name, None)
        if not getattr(method, MARK, False):
            raise UnsavableState(f"unknown call {name!r} in the journal")
        while made < steps:
            made += step(steps - made)
        getattr(engine, name)(*arguments)
    while made < saved["steps"]:
        made += step(saved["steps"] - made)

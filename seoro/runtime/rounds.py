"""Rounds: what is done in the present one, what is put down for the next, and the effects that take hold between.

No flow sees an effect of its own round. Between rounds they take hold in this order: changes of variables, what
depends on those, what ends behaviors, what is emitted.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterable
from functools import partial
from operator import itemgetter
from typing import Any, TypeAlias

from seoro.runtime.flows import Flow

StepOrder: TypeAlias = Callable[[tuple[int, ...]], Any]
"""Gives, for the path of a flow, the key by which the steps of a round are sorted."""

_Entries: TypeAlias = list[tuple[Any, Callable[[], None]]]


def by_path(path: tuple[int, ...]) -> Any:
    """The order of steps unless another is asked for."""
    return path


class Rounds:
    """The steps of the present round and of the next.

    Args:
        order: Of the steps of a round.
        cancel: Cancels a flow.
    """

    __slots__ = ("_cancel", "_cancelling", "_order", "_steps", "number", "present")

    def __init__(self, order: StepOrder, cancel: Callable[[Flow], None]) -> None:
        self.number = 0
        self._order = order
        self._cancel = cancel
        self._cancelling: list[Flow] = []
        self._steps: _Entries = []
        self.present: deque[Callable[[], None]] = deque()  # what is left to do in the present round

    @property
    def has_next(self) -> bool:
        """Whether there is anything to do in the next round."""
        return bool(self._steps or self._cancelling)

    def step(self, path: tuple[int, ...], step: Callable[[], None]) -> None:
        """Take a step in the next round, in order of paths."""
        self._steps.append((self._order(path), step))

    def cancel(self, flow: Flow) -> None:
        """Cancel a flow in the next round, before all steps, in order of paths."""
        self._cancelling.append(flow)

    def begin(self) -> None:
        """The next round is the present one now."""
        self.number += 1
        if self._cancelling:
            self._cancelling.sort(key=lambda flow: flow.path)
            for flow in self._cancelling:
                self.present.append(partial(self._cancel, flow))
            self._cancelling.clear()
        self.present.extend(_in_order(self._steps))
        self._steps.clear()


class Effects:
    """What was put down in a round; each with the path of what put it down.

    Args:
        broken: Called when one raises, which none should; the others take hold all the same.
    """

    __slots__ = ("_broken", "checks", "closings", "emissions", "ends", "writes")

    def __init__(self, broken: Callable[[Exception], None]) -> None:
        self._broken = broken
        self.writes: _Entries = []
        self.checks: _Entries = []
        self.ends: _Entries = []
        self.emissions: _Entries = []  # in the order of events and arguments
        self.closings: list[Callable[[], None]] = []  # ends of what hears emissions

    @property
    def are_there(self) -> bool:
        """Whether anything is to take hold."""
        return bool(self.writes or self.ends or self.emissions)

    def take_hold(self) -> None:
        """All of them, and what they put down in turn, but for changes of variables: those begin anew."""
        if self.writes:
            writes, self.writes = self.writes, []
            self._carry_out(writes)
        if self.checks:
            checks, self.checks = self.checks, []
            self._carry_out(checks)
        while self.ends or self.emissions:
            ends, self.ends = self.ends, []
            self._carry_out(ends)
            if not self.ends:
                emissions, self.emissions = self.emissions, []
                self._carry_out(emissions)
        if self.closings:
            closings, self.closings = self.closings, []
            self._call(closings)

    def _carry_out(self, effects: _Entries) -> None:
        self._call(_in_order(effects))

    def _call(self, effects: Iterable[Callable[[], None]]) -> None:
        for effect in effects:
            try:
                effect()
            except Exception as error:
                self._broken(error)


def _in_order(entries: _Entries) -> Iterable[Callable[[], None]]:
    """What is to be called, in order of keys; with one key, as it came."""
    if len(entries) > 1:
        entries.sort(key=itemgetter(0))
    return map(itemgetter(1), entries)

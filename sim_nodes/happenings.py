"""What happens in a simulation: held until a grant of time tells it, and kept for those who follow it.

See `seoro.bridges.wire.passing` for the first, and `seoro.bridges.wire.happened` for the second.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass
from itertools import islice

from seoro.bridges.wire import (
    LONGEST_WAIT,
    AnotherWorld,
    Contact,
    Departure,
    Happening,
    Happenings,
    NavigationFeedback,
    Occurrence,
    Result,
)
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.stateful import Stateful
from sim_nodes.worlds.loader import World

KEPT = 10_000  # things that a log has
AWAY = 3.0 * LONGEST_WAIT  # [s] of the machine's clock without a question, after which nobody follows any more

What = Occurrence | Contact | Departure | NavigationFeedback


@dataclass(frozen=True)
class Happened:
    """What happened up to a time, in order."""

    occurrences: tuple[Occurrence, ...]
    contacts: tuple[Contact, ...]
    feedback: tuple[NavigationFeedback, ...]
    departures: tuple[Departure, ...] = ()


class Pending(Stateful):
    """What has happened and was not told yet."""

    STATE = ("_occurrences", "_contacts", "_feedback", "_departures")

    def __init__(self) -> None:
        self._occurrences: list[Occurrence] = []
        self._contacts: list[Contact] = []
        self._feedback: list[NavigationFeedback] = []
        self._departures: list[Departure] = []

    def __bool__(self) -> bool:
        return bool(self._occurrences or self._contacts or self._feedback or self._departures)

    def add(self, what: What) -> None:
        """Hold what has happened."""
        match what:
            case Occurrence():
                self._occurrences.append(what)
            case Contact():
                self._contacts.append(what)
            case NavigationFeedback():
                self._feedback.append(what)
            case Departure():
                self._departures.append(what)

    def take(self) -> Happened:
        """All of it, which is told then."""
        happened = Happened(
            tuple(self._occurrences), tuple(self._contacts), tuple(self._feedback), tuple(self._departures)
        )
        self._occurrences, self._contacts, self._feedback, self._departures = [], [], [], []
        return happened

    def without_feedback(self) -> Pending:
        """The same without what was said of ways to goals."""
        kept = Pending()
        kept._occurrences, kept._contacts, kept._departures = self._occurrences, self._contacts, self._departures
        return kept


class Log:
    """What has happened in a simulator, whatever worlds it had, by numbers from 1 on.

    Attributes:
        worlds: How many worlds there have been; having none counts as one.
    """

    def __init__(self) -> None:
        self.worlds = 0
        self._world: World | None = None
        self._kept: deque[Happening] = deque(maxlen=KEPT)
        self._number = 0
        self._asked: float | None = None

    @property
    def number(self) -> int:
        """The number of what has happened last."""
        return self._number

    @property
    def is_followed(self) -> bool:
        """Whether somebody asks for what happens, again and again."""
        return self._asked is not None and time.monotonic() - self._asked < AWAY

    def add(self, what: What | AnotherWorld) -> None:
        """Keep what has happened."""
        self._number += 1
        match what:
            case Occurrence():
                happening = Happening(number=self._number, occurrence=what)
            case Contact():
                happening = Happening(number=self._number, contact=what)
            case Departure():
                happening = Happening(number=self._number, departure=what)
            case NavigationFeedback():
                happening = Happening(number=self._number, feedback=what)
            case AnotherWorld():
                happening = Happening(number=self._number, world=what)
        self._kept.append(happening)

    def note_world(self, world: World | None) -> None:
        """Keep that there is another world, or none any more, if so; the first one is nothing that happens."""
        if self.worlds and world == self._world:
            return
        self._world, self.worlds = world, self.worlds + 1
        if self.worlds > 1:
            self.add(AnotherWorld(number=self.worlds, world="" if world is None else world.name))

    def rewind(self, number: int) -> None:
        """Forget what has happened after a number: it has not."""
        while self._kept and self._kept[-1].number > number:
            self._kept.pop()
        self._number = number

    def since(self, number: int) -> Happenings:
        """What has happened after a number.

        Raises:
            RequestRefused: That number was never given, or it is so long ago that what came after it is gone.
        """
        self._asked = time.monotonic()
        if not self._number - len(self._kept) <= number <= self._number:
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"there is nothing to be told after number {number}: known are the last {len(self._kept)} things, "
                f"up to number {self._number}",
            )
        return Happenings(number=self._number, happenings=tuple(self.after(number)))

    def after(self, number: int) -> Iterator[Happening]:
        """What has happened after a number of which all is kept."""
        return islice(self._kept, len(self._kept) - (self._number - number), None)

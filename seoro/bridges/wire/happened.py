"""What happens while nobody grants time: goals that end, or do not, watches that fire, contacts, and more.

A node numbers what happens, from 1 on, and keeps it. A client asks for everything after the last number that it
has; the answer comes as soon as there is anything, or after the time that the client is willing to wait. Nothing
can get lost on the way, and what happened while a connection was broken is told after it.
"""

from __future__ import annotations

from seoro.bridges.wire.feedback import NavigationFeedback
from seoro.bridges.wire.message import Message, Verb
from seoro.bridges.wire.passing import HAPPENED, Contact, Departure, Occurrence

LONGEST_WAIT = 10.0  # [s] that a client may wait for an answer


class AwaitHappenings(Message):
    """Ask for what has happened after the number `since`; answered within `wait` [s], empty if there is nothing.

    A number that the node has not reached, or that is so long ago that it does not have it any more, is refused
    as INCORRECT_STATE: the client talks to another start of the node than it believes.
    """

    since: int = 0
    wait: float = 0.0


class AnotherWorld(Message):
    """Another world was loaded, or there is none any more: its number (see `SimulatorFeatures`), and its name."""

    number: int
    world: str


class Caution(Message):
    """What people have to know of a goal, by its id, such as that it was canceled and may go on."""

    id: str
    message: str


class Happening(Message):
    """One thing that happened; one of the parts says what."""

    number: int
    occurrence: Occurrence | None = None
    contact: Contact | None = None
    departure: Departure | None = None
    feedback: NavigationFeedback | None = None
    world: AnotherWorld | None = None
    caution: Caution | None = None


class Happenings(Message):
    """What has happened, in order. `number` is the last one's, or the one that was asked with."""

    number: int
    happenings: tuple[Happening, ...] = ()


AWAIT_HAPPENINGS = Verb("await_happenings", AwaitHappenings, Happenings, answers=HAPPENED)

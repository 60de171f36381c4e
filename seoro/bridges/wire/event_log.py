"""Event log of a node: ends of goals, fired watches, contacts and more, while no client grants time.

A node numbers its events from 1 and keeps them. A client requests all events after the last number that it has.
The node replies at the next event, or after the requested wait. No event is lost, and events during a broken
connection are sent after it.
"""

from __future__ import annotations

from seoro.bridges.wire.advance import EVENTS, Contact, Departure, Occurrence
from seoro.bridges.wire.message import Message, Verb
from seoro.bridges.wire.mobile import NavigationFeedback

LONGEST_WAIT = 10.0  # [s] maximum wait of a request


class AwaitEvents(Message):
    """Request the events after the number `since`; without any, the reply is empty after `wait` [s].

    A number that the node has not reached or no longer keeps is refused as INCORRECT_STATE: the node was
    restarted.
    """

    since: int = 0
    wait: float = 0.0


class WorldChange(Message):
    """Loading or unloading of a world: its number (see `SimulatorFeatures`) and name."""

    number: int
    world: str


class GoalWarning(Message):
    """Warning about a goal, by its id, such as a cancellation that the robot rejected."""

    id: str
    message: str


class LoggedEvent(Message):
    """A numbered event; exactly one of the other fields is set."""

    number: int
    occurrence: Occurrence | None = None
    contact: Contact | None = None
    departure: Departure | None = None
    feedback: NavigationFeedback | None = None
    world: WorldChange | None = None
    warning: GoalWarning | None = None


class LoggedEvents(Message):
    """Events in order. `number` is that of the last event, or that of the request."""

    number: int
    events: tuple[LoggedEvent, ...] = ()


AWAIT_EVENTS = Verb("await_events", AwaitEvents, LoggedEvents, reply_limits=EVENTS, waits=True)

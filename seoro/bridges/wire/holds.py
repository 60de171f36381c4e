"""Holds of robots: acquisition, heartbeats and release.

A robot obeys one client at a time, its holder. A client acquires several robots at once, all or none. It then
requests events by `hold_robots`, again after each reply; these requests are its heartbeat. If a heartbeat is later
than `HOLD_DEADLINE`, or the liveliness token of the client (`holder_token`) disappears, the node stops its robots
and aborts their goals. The client still holds them and may resume, until another client acquires them.

Clients with different robots of one node share its verbs, so an attachment of each request names its sender
(`encode_sender`). With keys, a code proves the sender (`seoro.security.signing.answers`).
"""

from __future__ import annotations

from typing import Annotated

from pydantic import Field

from seoro.bridges.wire.advance import EVENTS
from seoro.bridges.wire.event_log import AwaitEvents, LoggedEvents
from seoro.bridges.wire.message import Empty, Message, Query, Verb
from seoro.bridges.wire.simulator import RobotInfo

HOLD_WAIT = 0.1  # [s] wait of a client for events; its next request is the heartbeat
MAX_SENDER = 200  # [bytes]
QUEUE_PATIENCE = 3.0  # [s] until a queue entry without requests expires
HOLD_PATIENCE = 3.0  # [s] until a client stops reconnecting; its robots are stopped meanwhile
HOLD_DEADLINE = 0.4  # [s] between two heartbeats, so that robots are stopped within 0.5 s


class Holder(Message):
    """Client that holds robots.

    Attributes:
        holder: Unique name of the client.
        purpose: Purpose of the hold, for people.
        robots: Names of the robots; if empty, the whole node with its world and its clock.
        lease: Id of a lease by hand of these robots.
        waits: Whether a refused client keeps its place in the wait queue and retries soon; in a release, whether
            it releases the robots to retry for all.
        priority: Priority in the wait queue; higher ones come first.
        gives_signs: Whether the client sends heartbeats; without them, the hold lasts as long as its token.
        exchange: Public key of the client, which authenticates its later requests; empty without keys.
        number: Lower bound of the numbers of these requests.
    """

    holder: str
    purpose: str = ""
    robots: tuple[str, ...] = ()
    lease: str = ""
    waits: bool = False
    priority: int = 0
    gives_signs: bool = True
    exchange: Annotated[bytes, Field(max_length=32)] = b""
    number: Annotated[int, Field(ge=0)] = 0


class HoldRobots(AwaitEvents):
    """Heartbeat of a holder, which requests new events. Refused if the client holds no robots."""

    holder: str


class RobotFeatures(Message):
    """Features of a node with robots, sent at any time; a holder receives those of its robots."""

    version: str  # of seoro
    features: tuple[str, ...]  # names of the served verbs
    robots: tuple[RobotInfo, ...]
    number: int  # number of the last event
    holder: str = ""  # purposes of the present holders


def encode_sender(holder: str) -> bytes:
    """Encode the sender of a request, for its attachment."""
    return holder.encode()


def decode_sender(attachment: bytes) -> str:
    """Return the sender of a request; empty if unnamed."""
    return attachment[:MAX_SENDER].decode(errors="replace")


GET_ROBOT_FEATURES = Query("get_robot_features", Empty, RobotFeatures)
TAKE_ROBOTS = Verb("take_robots", Holder, RobotFeatures, is_audited=True)
HOLD_ROBOTS = Verb("hold_robots", HoldRobots, LoggedEvents, reply_limits=EVENTS, names_holder=True, waits=True)
RELEASE_ROBOTS = Verb("release_robots", Holder, Empty, names_holder=True)

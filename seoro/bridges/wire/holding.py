"""Robots that run by themselves: who holds them, and what they are held by.

A robot obeys one client at a time. That takes it, or several at once, all or none, and from then on asks for what
happens by `hold_robots`, again as soon as it has an answer. When it has not asked for `HOLD_DEADLINE`, or its
liveliness token (`holder_token`) is gone, the node stops its robots at once, and their goals end as aborted. A
client that gave no sign of life still holds them, and may go on when it is back, until another takes them.

Who sends a request says so beside its payload (`sender`), since clients with different robots of one node share
its verbs. Where there are keys, a code proves it (`seoro.keys.answers`).
"""

from __future__ import annotations

from typing import Annotated, Any

from pydantic import Field

from seoro.bridges.wire.happened import AwaitHappenings, Happenings
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.passing import HAPPENED
from seoro.bridges.wire.simulator import RobotInfo

HOLD_WAIT = 0.05  # [s] that a client waits for happenings; it asks again then, which is its sign of life
MAX_SENDER = 200  # [bytes]
QUEUE_PATIENCE = 3.0  # [s] that a place in line is kept for a client that does not ask
HOLD_PATIENCE = 3.0  # [s] for which a client tries to reach a node again, whose robots stand still meanwhile
HOLD_DEADLINE = 0.4  # [s] between two signs of life, so that robots are stopped within 0.5 s


class Holder(Message):
    """Who holds robots, by a name of its own.

    Attributes:
        purpose: For people, such as the scenario that is run.
        robots: Which ones; all of the node, with its world and its clock, when there are none.
        lease: Id of a lease by hand under which they are taken.
        waits: Whether a client that does not get them comes back soon, and keeps its place in line meanwhile; in a
            release, whether it gives back what it has to come back for it.
        priority: Of its place in line; higher ones come first.
        gives_signs: Whether it gives signs of life; else its token alone is what it holds them by.
        exchange: Public key of the client, which authenticates its later requests; empty without keys.
        number: Lower than the numbers of these requests.
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


class HoldRobots(AwaitHappenings):
    """A sign of life of a holder, which asks for what has happened meanwhile. Refused if it does not hold them."""

    holder: str


class RobotFeatures(Message):
    """What a node with robots is and has, answered at any time; who takes robots is told of these alone."""

    version: str  # of seoro
    features: tuple[str, ...]  # names of the verbs it serves
    robots: tuple[RobotInfo, ...]
    number: int  # of the last thing that happened
    holder: str = ""  # what the client is there for that holds them now


def sender(holder: str) -> bytes:
    """What travels beside the payload of a request and says whose it is."""
    return holder.encode()


def sender_of(attachment: bytes) -> str:
    """Who sends a request; empty if it does not say."""
    return attachment[:MAX_SENDER].decode(errors="replace")


GET_ROBOT_FEATURES = Verb("get_robot_features", Empty, RobotFeatures)
TAKE_ROBOTS = Verb("take_robots", Holder, RobotFeatures)
HOLD_ROBOTS = Verb("hold_robots", HoldRobots, Happenings, answers=HAPPENED)
RELEASE_ROBOTS = Verb("release_robots", Holder, Empty)
BRIDGE_VERBS: tuple[Verb[Any, Any], ...] = (GET_ROBOT_FEATURES, TAKE_ROBOTS, HOLD_ROBOTS, RELEASE_ROBOTS)

"""What somebody sees of a lab from where they are: at which endpoints who answers, and how well.

An executor is asked for it, since scenarios run from there: what it reaches is not what its clients reach.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Annotated, Final

from pydantic import Field

from seoro.bridges.executor.messages import Said, Text
from seoro.bridges.wire.lab import LabState
from seoro.bridges.wire.message import Verb

MAX_PLACES: Final = 32
LOOKED_WITHIN: Final = 30.0  # [s] that an executor may take to look


class Hop(StrEnum):
    """Where the way to an endpoint ends."""

    POLICY = "policy"  # of the executor that was asked
    KEYS = "keys"
    SESSION = "session"


class NodeSeen(Said):
    """A node, a simulator or a bridge, as somebody sees it.

    Attributes:
        node: Its name.
        count: How many nodes have that name.
        major: Version of the protocol that it speaks.
        why: Why it cannot be asked, in words; empty if it can.
        state: How its robots are.
        is_usable: Whether it lets whoever looks use its robots; None if their role does not.
        why_not: Why it does not, in words.
        offset: How far its clock is ahead of the one who looks [s]; None if it does not tell.
        doubt: By how much that may be wrong [s].
        half: Within what time half of the answers came [s].
        most: Within what time 99 % did.
        exchanges: How many there were.
    """

    node: str
    count: int = 1
    major: str = ""
    why: str = ""
    state: LabState | None = None
    is_usable: bool | None = None
    why_not: str = ""
    offset: float | None = None
    doubt: float = 0.0
    half: float = 0.0
    most: float = 0.0
    exchanges: int = 0


class PlaceSeen(Said):
    """An endpoint, and the nodes that are reached there.

    Attributes:
        endpoint: The endpoint.
        who: Who has looked, by name and role; empty where there are no keys.
        ends_at: Where the way there ends; None if it does not.
        why: Why it does, in words.
        advice: What to do about that.
        nodes: Who is there.
    """

    endpoint: str
    who: str = ""
    ends_at: Hop | None = None
    why: str = ""
    advice: str = ""
    nodes: tuple[NodeSeen, ...] = ()


class Look(Said):
    """Asks an executor what it sees at endpoints.

    Attributes:
        role: Of who asks, by their keys: an executor with keys finds out by itself.
    """

    endpoints: Annotated[tuple[Text, ...], Field(min_length=1, max_length=MAX_PLACES)]
    role: Text = ""


class Sight(Said):
    """What it sees, in the order of the endpoints."""

    places: tuple[PlaceSeen, ...]


LOOK: Final = Verb("look", Look, Sight)

"""Robots that run by themselves: who holds them, and what they are held by.

Robots behind a bridge obey one client at a time. It takes them, and from then on asks for what happens by
`hold_robots`, again as soon as it has an answer. When it has not asked for `HOLD_DEADLINE`, or its liveliness
token (`holder_token`) is gone, the bridge stops all robots at once, and all goals end as aborted. The client still
holds them, and may go on when it is back, until another takes them.
"""

from __future__ import annotations

from typing import Any

from seoro.bridges.wire.happened import AwaitHappenings, Happenings
from seoro.bridges.wire.message import Empty, Message, Verb
from seoro.bridges.wire.simulator import RobotInfo

HOLD_WAIT = 0.05  # [s] that a client waits for happenings; it asks again then, which is its sign of life
HOLD_DEADLINE = 0.4  # [s] between two signs of life, so that robots are stopped within 0.5 s


class Holder(Message):
    """Who holds robots, by a name of its own; `purpose` is for people, such as the scenario that is run."""

    holder: str
    purpose: str = ""


class HoldRobots(AwaitHappenings):
    """A sign of life of a holder, which asks for what has happened meanwhile. Refused if it does not hold them."""

    holder: str


class RobotFeatures(Message):
    """What a bridge to robots is and has; answered at any time."""

    version: str  # of seoro
    features: tuple[str, ...]  # names of the verbs it serves
    robots: tuple[RobotInfo, ...]
    number: int  # of the last thing that happened
    holder: str = ""  # what the client is there for that holds them now


GET_ROBOT_FEATURES = Verb("get_robot_features", Empty, RobotFeatures)
TAKE_ROBOTS = Verb("take_robots", Holder, RobotFeatures)
HOLD_ROBOTS = Verb("hold_robots", HoldRobots, Happenings)
RELEASE_ROBOTS = Verb("release_robots", Holder, Empty)
BRIDGE_VERBS: tuple[Verb[Any, Any], ...] = (GET_ROBOT_FEATURES, TAKE_ROBOTS, HOLD_ROBOTS, RELEASE_ROBOTS)

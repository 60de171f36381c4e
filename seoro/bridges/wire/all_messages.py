"""All messages and verbs of nodes and their clients; the content of `seoro.bridges.wire`."""

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from seoro.bridges.wire import authentication, holds, lab
from seoro.bridges.wire.advance import *
from seoro.bridges.wire.arms import *
from seoro.bridges.wire.authentication import *
from seoro.bridges.wire.buildings import *
from seoro.bridges.wire.cameras import *
from seoro.bridges.wire.entities import *
from seoro.bridges.wire.event_log import *
from seoro.bridges.wire.faults import *
from seoro.bridges.wire.geometry import *
from seoro.bridges.wire.holds import *
from seoro.bridges.wire.keys import *
from seoro.bridges.wire.lab import *
from seoro.bridges.wire.limits import *
from seoro.bridges.wire.listing import *
from seoro.bridges.wire.measures import *
from seoro.bridges.wire.message import *
from seoro.bridges.wire.mobile import *
from seoro.bridges.wire.outputs import *
from seoro.bridges.wire.people import *
from seoro.bridges.wire.results import *
from seoro.bridges.wire.scene import *
from seoro.bridges.wire.sensors import *
from seoro.bridges.wire.simulator import *
from seoro.bridges.wire.snapshots import *
from seoro.bridges.wire.streams import *
from seoro.bridges.wire.tracks import *
from seoro.robotics.faults import *
from seoro.robotics.geometry import *
from seoro.robotics.measures import *
from seoro.robotics.people import *

_NOT_OF_SIMULATORS = {
    value for module in (authentication, holds, lab) for value in vars(module).values() if isinstance(value, Verb)
}
_ALL: tuple[Verb[Any, Any], ...] = tuple(value for value in tuple(globals().values()) if isinstance(value, Verb))
VERBS: tuple[Verb[Any, Any], ...] = tuple(verb for verb in _ALL if verb not in _NOT_OF_SIMULATORS)
"""Verbs of simulators; bridges serve the subset that their robots support."""

NODE_VERBS: Mapping[str, Verb[Any, Any]] = MappingProxyType(
    {verb.name: verb for verb in _ALL if verb is not authentication.CLAIM}
)
"""Verbs of simulators and bridges, by name."""

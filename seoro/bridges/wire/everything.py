"""All that nodes and their clients say, at one place; what `seoro.bridges.wire` has."""

from typing import Any

from seoro.bridges.wire.arms import *
from seoro.bridges.wire.artifacts import *
from seoro.bridges.wire.cameras import *
from seoro.bridges.wire.description import *
from seoro.bridges.wire.driving import *
from seoro.bridges.wire.entities import *
from seoro.bridges.wire.faults import *
from seoro.bridges.wire.feedback import *
from seoro.bridges.wire.filters import *
from seoro.bridges.wire.geometry import *
from seoro.bridges.wire.happened import *
from seoro.bridges.wire.holding import *
from seoro.bridges.wire.holding import BRIDGE_VERBS
from seoro.bridges.wire.keys import *
from seoro.bridges.wire.lab import *
from seoro.bridges.wire.lab import LAB_VERBS
from seoro.bridges.wire.limits import *
from seoro.bridges.wire.listing import *
from seoro.bridges.wire.localisation import *
from seoro.bridges.wire.maps import *
from seoro.bridges.wire.measurements import *
from seoro.bridges.wire.message import *
from seoro.bridges.wire.message import Verb
from seoro.bridges.wire.mobile import *
from seoro.bridges.wire.passing import *
from seoro.bridges.wire.poses import *
from seoro.bridges.wire.proving import *
from seoro.bridges.wire.proving import CHALLENGE, CLAIM
from seoro.bridges.wire.recording import *
from seoro.bridges.wire.results import *
from seoro.bridges.wire.sensors import *
from seoro.bridges.wire.simulator import *
from seoro.bridges.wire.snapshots import *
from seoro.bridges.wire.spawnables import *
from seoro.bridges.wire.streams import *

# What simulators serve; bridges to robots serve what robots can. Both have `BRIDGE_VERBS` and `LAB_VERBS` besides.
_OF_NODES = {*BRIDGE_VERBS, *LAB_VERBS, CHALLENGE, CLAIM}
VERBS: tuple[Verb[Any, Any], ...] = tuple(
    value for value in tuple(globals().values()) if isinstance(value, Verb) and value not in _OF_NODES
)

"""What nodes and their clients say to each other: messages, verbs and key expressions. No I/O.

A node is a simulator, or a bridge to robots.

A request is a Zenoh query on `node_command(...)`, its payload the msgpack map of the verb's request model, its
answer that of the verb's reply model, or, as an error reply, a `Refusal`. Verbs, fields and result codes are
those of ROS `simulation_interfaces` 2.1 where it has them; what it lacks (time grants, robots, watches)
is named after the ROS messages and actions for the same purpose.

Units are SI, angles radians, the frame is the world's `map` unless a field says otherwise. Orientations are
roll, pitch, yaw after ISO 8855 (yaw first). Times are seconds of the simulator's clock.

How those who serve requests check and refuse them is in `refusal.py`.

The major version stands in every key. Within a major version fields are only added, with defaults, and
readers ignore what they do not know.
"""

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
from seoro.bridges.wire.listing import *
from seoro.bridges.wire.localisation import *
from seoro.bridges.wire.maps import *
from seoro.bridges.wire.measurements import *
from seoro.bridges.wire.message import *
from seoro.bridges.wire.message import Verb
from seoro.bridges.wire.mobile import *
from seoro.bridges.wire.passing import *
from seoro.bridges.wire.poses import *
from seoro.bridges.wire.recording import *
from seoro.bridges.wire.results import *
from seoro.bridges.wire.sensors import *
from seoro.bridges.wire.simulator import *
from seoro.bridges.wire.snapshots import *
from seoro.bridges.wire.spawnables import *
from seoro.bridges.wire.streams import *

# What simulators serve; bridges to robots serve what robots can, and `BRIDGE_VERBS` besides.
VERBS: tuple[Verb[Any, Any], ...] = tuple(
    value for value in tuple(globals().values()) if isinstance(value, Verb) and value not in BRIDGE_VERBS
)

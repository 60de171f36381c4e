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

What executors and their clients say is in `seoro.bridges.executor`: hundreds of messages take a tenth of a
second to load, which who has no simulator does without. So they are loaded when the first of them is asked for.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seoro.bridges.wire.everything import *
    from seoro.bridges.wire.everything import VERBS as VERBS
    from seoro.bridges.wire.holding import BRIDGE_VERBS as BRIDGE_VERBS
    from seoro.bridges.wire.lab import LAB_VERBS as LAB_VERBS
    from seoro.bridges.wire.message import Verb as Verb


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    everything = vars(import_module("seoro.bridges.wire.everything"))
    globals().update({each: value for each, value in everything.items() if not each.startswith("__")})
    try:
        return everything[name]
    except KeyError:
        raise AttributeError(f"module 'seoro.bridges.wire' has no attribute {name!r}") from None

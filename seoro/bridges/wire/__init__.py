"""Protocol between nodes and their clients: messages, verbs and key expressions. No I/O.

A node is a simulator, or a bridge to robots.

A request is a Zenoh query on `node_command(...)`. Its payload is the msgpack map of the request model of its verb.
The reply is the map of the verb's reply model, or an error reply with a `Refusal`. A `Verb` declares both models,
limits and permissions. Verbs, fields and result codes follow ROS `simulation_interfaces` 2.1 where it has them.
The rest (time grants, robots, watches) is named after the ROS messages and actions for the same purpose.

Units are SI, angles radians; poses are in the world's frame `map` unless a field names another. Orientations are
roll, pitch, yaw after ISO 8855 (yaw first). Times are seconds of the simulator's clock.

Checks and refusals of requests are in `refusal.py`.

Every key contains the major version. Within a major version fields are only added, with defaults, and readers
ignore unknown fields.

Messages of executors and their clients are in `seoro.bridges.executor`. Loading the messages of this package takes
a tenth of a second, so they are loaded on first use.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from seoro.bridges.wire.all_messages import *
    from seoro.bridges.wire.all_messages import NODE_VERBS as NODE_VERBS
    from seoro.bridges.wire.all_messages import VERBS as VERBS


def __getattr__(name: str) -> Any:
    if name.startswith("__"):
        raise AttributeError(name)
    everything = vars(import_module("seoro.bridges.wire.all_messages"))
    globals().update({each: value for each, value in everything.items() if not each.startswith("__")})
    try:
        return everything[name]
    except KeyError:
        raise AttributeError(f"module 'seoro.bridges.wire' has no attribute {name!r}") from None

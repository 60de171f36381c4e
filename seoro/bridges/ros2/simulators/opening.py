"""A simulator of the ROS world for a run (`--sim ros`), without a process of its own: this one is the node."""

from __future__ import annotations

import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

from seoro.bridges.launch import SimulatorOptions, connect_simulator, folder_for_sockets
from seoro.bridges.ros2.backend import RosOptions, reach
from seoro.bridges.ros2.simulators.node import serving_simulator
from seoro.bridges.session import SessionError, open_session
from seoro.bridges.sim.node import SimulatorNode
from seoro.errors import InvalidUse

NODE = "ros"


@asynccontextmanager
async def open_simulator(system: RosOptions, options: SimulatorOptions) -> AsyncIterator[SimulatorNode]:
    """Use the simulator of a ROS 2 system for as long as the block lasts; paused after it, where time was granted.

    Args:
        system: The ROS 2 system, and how it is reached.
        options: What a run wants of its simulator.

    Raises:
        InvalidUse: There is no router, no simulator, or none that can be used.
        BackendError: No ROS 2 system is seen there.
    """
    with tempfile.TemporaryDirectory(prefix="seoro-", dir=folder_for_sockets()) as folder:
        endpoint = f"unixsock-stream/{Path(folder) / 'hub.sock'}"
        try:
            async with (
                reach(system) as reached,
                open_session(listen=endpoint) as hub,
                serving_simulator(hub, NODE, reached),
                connect_simulator(endpoint, options) as node,
            ):
                yield node
        except SessionError as error:
            raise InvalidUse(str(error), help="`--ros ENDPOINT` says where the router is") from error

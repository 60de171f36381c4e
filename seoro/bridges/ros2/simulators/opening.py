"""A ROS simulator for a run (`--sim ros`); its simulator node is in the process of the run."""

from __future__ import annotations

import tempfile
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio.to_thread

from seoro.bridges.launch import SimulatorOptions, connect_simulator, folder_for_sockets
from seoro.bridges.ros2.participant import RosOptions, connect_system
from seoro.bridges.ros2.simulators.node import serving_simulator
from seoro.bridges.session import SessionError, open_session
from seoro.bridges.sim.node import SimulatorNode
from seoro.errors import UsageError

NODE = "ros"


@asynccontextmanager
async def open_simulator(system: RosOptions, options: SimulatorOptions) -> AsyncIterator[SimulatorNode]:
    """Use the simulator of a ROS 2 system during the block; if the run made steps, it stays paused afterwards.

    Args:
        system: Options of the connection to the ROS 2 system.
        options: Options of the run.

    Raises:
        UsageError: The router or the simulator is missing, or the simulator is unsuitable.
        BackendError: No ROS 2 system was found.
    """
    with tempfile.TemporaryDirectory(prefix="seoro-", dir=folder_for_sockets()) as folder:
        endpoint = f"unixsock-stream/{Path(folder) / 'hub.sock'}"
        try:
            async with connect_system(system) as reached:
                await anyio.to_thread.run_sync(reached.prepare)
                async with (
                    open_session(listen=endpoint) as hub,
                    serving_simulator(hub, NODE, reached),
                    connect_simulator(endpoint, options) as node,
                ):
                    yield node
        except SessionError as error:
            raise UsageError(str(error), help="`--ros ENDPOINT` sets the router") from error

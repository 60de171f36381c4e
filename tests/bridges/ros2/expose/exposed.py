"""An exposed simulator node, and a ROS 2 node at the same router."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager, suppress
from dataclasses import dataclass, replace
from typing import Any

import anyio

from seoro.bridges import wire
from seoro.bridges.ros2.expose.running import ExposeSettings, expose
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.topics import Subscription
from seoro.bridges.ros2.wire import Qos, RmwZenoh
from seoro.bridges.session import AsyncSession, open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.bridges.wire import SimulationState
from seoro.bridges.wire.keys import NAMESPACE
from seoro.concurrency.background import background
from seoro.errors import BackendRefused
from tests.sim_nodes.client import A, Q

STARTED_WITHIN = 30.0  # [s]
KEEPING = Qos(depth=1000)


@dataclass(frozen=True)
class Exposed:
    """Both sides of an exposed simulator.

    Attributes:
        ros: ROS 2 node of another participant.
    """

    ros: RosNode
    _session: AsyncSession

    async def ask(self, verb: wire.Verb[Q, A], request: Q) -> A:
        """Send a request to the simulator node directly."""
        return await ask(NodeAddress(self._session, NAMESPACE, "sim"), verb, request)


@asynccontextmanager
async def exposed(
    simulator: str,
    router: str,
    types: TypeStore,
    world: str = "empty",
    rate: float | None = None,
    **settings: Any,
) -> AsyncIterator[Exposed]:
    """Yield a simulator node that is exposed at a router, at the start of a world.

    Args:
        simulator: Endpoint of the node.
        router: Endpoint of the router.
        types: Definitions of types.
        world: Name of the world.
        rate: Real-time factor of the simulator; None while it is paused.
        settings: Further settings of the exposing node.
    """
    async with open_session(connect=simulator) as session:
        address = NodeAddress(session, NAMESPACE, "sim")
        await ask(address, wire.LOAD_WORLD, wire.LoadWorld(world=world, seed=3))
        async with background() as tasks:
            ready = anyio.Event()
            wanted = replace(ExposeSettings(simulator, router), **settings)
            tasks.start_soon(expose, wanted, lambda _: ready.set())
            with anyio.fail_after(STARTED_WITHIN):
                await ready.wait()
            async with (
                connect(router, types=types, dialect=RmwZenoh()) as system,
                system.node("viewer") as ros,
            ):
                if rate is not None:
                    playing = wire.SetSimulationState(state=SimulationState.PLAYING, rate=rate)
                    await ask(address, wire.SET_SIMULATION_STATE, playing)
                yield Exposed(ros, session)


async def step(node: Exposed, steps: int) -> None:
    """Simulate some steps, and receive all their messages."""
    # The response arrives after the announcements of the subscriptions; without them, nothing would be sent.
    async with node.ros.calling("/get_simulation_state", "simulation_interfaces/srv/GetSimulationState") as client:
        await client.wait_for_server(30.0)
        await client.call({}, 5.0)
    await node.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=steps))


async def under_way(node: Exposed) -> None:
    """Wait until the robot has a goal."""
    with anyio.fail_after(30.0):
        while True:
            with suppress(BackendRefused):
                await node.ask(wire.GET_NAVIGATION_FEEDBACK, wire.RobotName(robot="turtlebot4"))
                return


async def first(subscription: Subscription, count: int = 1, within: float = 10.0) -> list[Any]:
    """Return the next messages of a subscription."""
    with anyio.fail_after(within):
        return [await subscription.message() for _ in range(count)]

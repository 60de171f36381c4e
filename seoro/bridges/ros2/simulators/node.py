"""Simulator node of a simulator with `simulation_interfaces`."""

from __future__ import annotations

import math
import secrets
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

from seoro import __version__
from seoro.bridges import wire
from seoro.bridges.ros2.participant import BRIDGE, RosSystem
from seoro.bridges.ros2.simulators.interfaces import SimulationInterfaces
from seoro.bridges.ros2.simulators.world import RosWorld, opening_world, relative_pose
from seoro.bridges.serving.answering import answer
from seoro.bridges.session import AsyncSession, Bound, Mailbox, Request
from seoro.bridges.wire import Empty, Result, SimulationState
from seoro.bridges.wire.refusal import RequestRefused, check_finite, name_list, read_request
from seoro.concurrency.background import background
from seoro.errors import UsageError

WAITING = Bound(256, drop="newest")  # queue of requests
SCOPE = wire.ResetScope.STATE | wire.ResetScope.SPAWNED

DISCOVERY_TIMEOUT = 5.0  # [s]
REQUIRED = (
    "get_simulator_features",
    "get_entities_states",
    "step_simulation",
    "set_simulation_state",
    "get_simulation_state",
)
"""Required services of a simulator."""

Handler = Callable[[Any], Awaitable[wire.Message | None]]


class RosSimulator:
    """A simulator node. Methods that are named like verbs handle them.

    Args:
        world: World of the simulator.
        features: Features of the simulator.
    """

    def __init__(self, world: RosWorld, features: Any) -> None:
        self._world = world
        self._simulator = world.simulator
        self._simulator_features = features
        self._verbs = {verb.name: verb for verb in wire.VERBS if hasattr(self, verb.name)}

    async def run(self, requests: Mailbox[Request]) -> None:
        """Answer requests one after the other."""
        async for request in requests:
            await answer(request, self._carry_out, "bridge")

    async def _carry_out(self, name: str, payload: bytes) -> wire.Message | None:
        if name not in self._verbs:
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED,
                f"a ROS simulator does not serve {name!r} (verbs: {name_list(self._verbs)}); use the topics of "
                "its robots",
            )
        handler: Handler = getattr(self, name)
        return await handler(read_request(self._verbs[name], payload))

    # ------------------------------------------------------------ simulation and time

    async def get_simulator_features(self, _: Empty) -> wire.SimulatorFeatures:
        return wire.SimulatorFeatures(
            engine="ros",
            engine_version=self._simulator_features.custom_info,
            version=__version__,
            features=tuple(self._verbs),
            spawn_formats=tuple(self._simulator_features.spawn_formats),
            world=await self._current_world(),
            available_worlds=await self._available_worlds(),
            robots=(),  # robots are accessed by their topics
            time=self._world.time,
            step=self._world.step_length,
            state=SimulationState.PAUSED,
        )

    async def _current_world(self) -> str:
        if not self._simulator.serves("get_current_world"):
            return ""
        response = await self._simulator.call("get_current_world")
        return str(response.world.name)

    async def _available_worlds(self) -> tuple[str, ...]:
        if not self._simulator.serves("get_available_worlds"):
            return ()
        worlds = (await self._simulator.call("get_available_worlds")).worlds
        return tuple(str(world.world_resource.uri) or str(world.name) for world in worlds)

    async def load_world(self, request: wire.LoadWorld) -> wire.SimulatorFeatures:
        """Load a world; without a name, reset the present one."""
        if request.world:
            await self._simulator.call("load_world", {"world_resource": {"uri": request.world}})
        else:
            await self._simulator.call("reset_simulation", {"scope": SCOPE})
        await self._simulator.pause()
        self._world.reset_time()
        return await self.get_simulator_features(Empty())

    async def advance(self, request: wire.Advance) -> wire.Advanced:
        check_finite("time", request.until)
        await self._world.advance(request.until)
        return wire.Advanced(time=self._world.time)

    async def step_simulation(self, request: wire.StepSimulation) -> wire.SimulationTime:
        await self._world.step(request.steps)
        return wire.SimulationTime(time=self._world.time)

    async def reset_simulation(self, request: wire.ResetSimulation) -> None:
        await self._simulator.call("reset_simulation", {"scope": request.scope})

    async def get_artifacts(self, _: Empty) -> wire.Artifacts:
        return wire.Artifacts(artifacts=())

    # ------------------------------------------------------------ entities

    async def spawn_entity(self, request: wire.SpawnEntity) -> wire.Spawned:
        return wire.Spawned(name=await self._simulator.spawn(request))

    async def spawn_entities(self, request: wire.SpawnEntities) -> wire.SpawnOutcomes:
        return wire.SpawnOutcomes(results=tuple([await self._try_spawn(each) for each in request.entities]))

    async def _try_spawn(self, request: wire.SpawnEntity) -> wire.SpawnOutcome:
        try:
            return wire.SpawnOutcome(name=await self._simulator.spawn(request))
        except RequestRefused as refused:
            return wire.SpawnOutcome(name=request.name, code=refused.code, message=refused.message)

    async def delete_entity(self, request: wire.EntityName) -> None:
        await self._simulator.call("delete_entity", {"entity": request.name})

    async def get_entities(self, request: wire.EntityFilter) -> wire.Entities:
        if request != wire.EntityFilter(filter=request.filter):
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, "unsupported filter: expected one of names only")
        found = await self._simulator.call("get_entities", {"filters": {"filter": request.filter}})
        return wire.Entities(names=tuple(sorted(found.entities)))

    async def get_entity_state(self, request: wire.EntityName) -> wire.EntityState:
        states = await self._simulator.states()
        if request.name not in states.entities:
            known = name_list(states.entities)
            raise RequestRefused(Result.NOT_FOUND, f"unknown entity {request.name!r} (entities: {known})")
        return states.of(request.name)

    async def set_entity_state(self, request: wire.SetEntityState) -> None:
        await self._simulator.set_state(request)

    async def get_relative_pose(self, request: wire.RelativePose) -> wire.FramePose:
        check_finite("distance", request.distance)
        x, y, yaw = relative_pose(await self._simulator.states(), request.frame, request.parent_frame)
        position = wire.Position3D(x=x + request.distance * math.cos(yaw), y=y + request.distance * math.sin(yaw))
        return wire.FramePose(position=position, orientation=wire.Orientation3D(yaw=yaw))


@asynccontextmanager
async def serving_simulator(
    session: AsyncSession, name: str, system: RosSystem, namespace: str = "/"
) -> AsyncIterator[RosSimulator]:
    """Serve a simulator of a ROS 2 system as a simulator node during the block.

    Args:
        session: Session of the node.
        name: Name of the node.
        system: The ROS 2 system.
        namespace: Namespace of the services of the simulator.

    Raises:
        UsageError: The simulator is missing, or lacks a required service.
    """
    busy = wire.encode(wire.Refusal(code=Result.OPERATION_FAILED, message="the node is busy: ask again later"))
    async with AsyncExitStack() as stack:
        ros = await stack.enter_async_context(system.node(BRIDGE, namespace))
        simulator = SimulationInterfaces(ros, stack)
        await _wait_for_services(simulator, system, namespace)
        try:
            features = (await simulator.call("get_simulator_features")).features
            served = RosSimulator(await stack.enter_async_context(opening_world(simulator)), features)
        except RequestRefused as refused:
            raise UsageError(f"cannot use the simulator: {refused.message}") from refused
        key, token = wire.node_command(wire.NAMESPACE, name, "*"), secrets.token_hex(8)
        requests = await stack.enter_async_context(session.answering(key, WAITING, busy))
        await stack.enter_async_context(session.token(wire.node_token(wire.NAMESPACE, name, token)))
        tasks = await stack.enter_async_context(background())
        tasks.start_soon(served.run, requests)
        yield served


async def _wait_for_services(simulator: SimulationInterfaces, system: RosSystem, namespace: str) -> None:
    try:
        await system.graph.wait_for(lambda _: all(map(simulator.serves, REQUIRED)), DISCOVERY_TIMEOUT)
    except TimeoutError:
        missing = name_list(name for name in REQUIRED if not simulator.serves(name))
        raise UsageError(
            f"no simulator with the services of `simulation_interfaces` in {namespace}",
            help=f"missing services: {missing}",
        ) from None

"""Serving the verbs of simulator nodes by a simulator of the ROS world."""

from __future__ import annotations

import logging
import math
import secrets
from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import AsyncExitStack, asynccontextmanager
from types import MappingProxyType
from typing import Any

from seoro import __version__
from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.ros2.own_nodes import BRIDGE
from seoro.bridges.ros2.participant import RosSystem
from seoro.bridges.ros2.simulators.interfaces import FOUND_WITHIN, NEEDED, SimulationInterfaces
from seoro.bridges.ros2.simulators.world import RosWorld, opening_world, relative
from seoro.bridges.session import AsyncSession, Bound, Mailbox, Request
from seoro.bridges.wire import Empty, Result, SimulationState
from seoro.bridges.wire.keys import verb_of
from seoro.bridges.wire.refusal import RequestRefused, check_finite, listed
from seoro.errors import InvalidUse

WAITING = Bound(256, lose="newest")  # requests
SCOPE = wire.ResetScope.STATE | wire.ResetScope.SPAWNED

Handler = Callable[[Any], Awaitable[wire.Message]]

log = logging.getLogger(__name__)


class RosSimulator:
    """A simulator of the ROS world as a node.

    Args:
        world: The simulation.
        features: What the simulator says of itself.
    """

    def __init__(self, world: RosWorld, features: Any) -> None:
        self._world = world
        self._simulator = world.simulator
        self._told = features
        handlers: dict[wire.Verb[Any, Any], Handler] = {
            wire.GET_SIMULATOR_FEATURES: self._features,
            wire.LOAD_WORLD: self._load_world,
            wire.ADVANCE: self._advance,
            wire.STEP_SIMULATION: self._step,
            wire.RESET_SIMULATION: self._reset,
            wire.SPAWN_ENTITY: self._spawn,
            wire.SPAWN_ENTITIES: self._spawn_many,
            wire.DELETE_ENTITY: self._delete,
            wire.GET_ENTITIES: self._entities,
            wire.GET_ENTITY_STATE: self._state,
            wire.SET_ENTITY_STATE: self._set_state,
            wire.GET_RELATIVE_POSE: self._relative_pose,
            wire.GET_ARTIFACTS: self._artifacts,
        }
        self.verbs = MappingProxyType({verb.name: (verb, handler) for verb, handler in handlers.items()})

    async def answer(self, request: Request) -> None:
        """Carry out a request and answer it, whatever happens."""
        name = verb_of(request.key)
        try:
            request.reply(wire.encode(await self._carry_out(name, request.payload)))
        except RequestRefused as refused:
            request.refuse(wire.encode(wire.Refusal(code=refused.code, message=refused.message)))
        except Exception as error:
            log.exception("fault in %s", name)
            message = f"fault in the bridge: {type(error).__name__}: {error}"
            request.refuse(wire.encode(wire.Refusal(code=Result.OPERATION_FAILED, message=message)))

    async def _carry_out(self, name: str, payload: bytes) -> wire.Message:
        if name not in self.verbs:
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED,
                f"a simulator of ROS serves no {name!r} here, but {listed(self.verbs)}; robots in it are reached "
                "by their topics",
            )
        verb, handler = self.verbs[name]
        try:
            request = verb.read(payload)
        except wire.WireError as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error
        return await handler(request)

    # ------------------------------------------------------------ the whole, and time

    async def _features(self, _: Empty) -> wire.SimulatorFeatures:
        return wire.SimulatorFeatures(
            engine="ros",
            engine_version=self._told.custom_info,
            version=__version__,
            features=tuple(self.verbs),
            spawn_formats=tuple(self._told.spawn_formats),
            world=await self._current_world(),
            available_worlds=await self._available_worlds(),
            robots=(),  # which are reached by their topics
            time=self._world.time,
            step=self._world.step_length,
            state=SimulationState.PAUSED,
        )

    async def _current_world(self) -> str:
        if not self._simulator.serves("get_current_world"):
            return ""
        response = await self._simulator.call("get_current_world", "GetCurrentWorld", {})
        return str(response.world.name)

    async def _available_worlds(self) -> tuple[str, ...]:
        if not self._simulator.serves("get_available_worlds"):
            return ()
        worlds = (await self._simulator.call("get_available_worlds", "GetAvailableWorlds", {})).worlds
        return tuple(str(world.world_resource.uri) or str(world.name) for world in worlds)

    async def _load_world(self, request: wire.LoadWorld) -> wire.SimulatorFeatures:
        """Load a world; without a name, start over in the one that there is."""
        if request.world:
            resource = {"world_resource": {"uri": request.world}}
            await self._simulator.call("load_world", "LoadWorld", resource)
        else:
            await self._simulator.call("reset_simulation", "ResetSimulation", {"scope": SCOPE})
        await self._simulator.pause()
        self._world.start_over()
        return await self._features(Empty())

    async def _advance(self, request: wire.Advance) -> wire.Advanced:
        check_finite("time", request.until)
        await self._world.advance(request.until)
        return wire.Advanced(time=self._world.time)

    async def _step(self, request: wire.StepSimulation) -> wire.SimulationTime:
        await self._world.step(request.steps)
        return wire.SimulationTime(time=self._world.time)

    async def _reset(self, request: wire.ResetSimulation) -> Empty:
        await self._simulator.call("reset_simulation", "ResetSimulation", {"scope": request.scope})
        return Empty()

    async def _artifacts(self, _: Empty) -> wire.Artifacts:
        return wire.Artifacts(artifacts=())

    # ------------------------------------------------------------ entities

    async def _spawn(self, request: wire.SpawnEntity) -> wire.EntityName:
        return wire.EntityName(name=await self._simulator.spawn(request))

    async def _spawn_many(self, request: wire.SpawnEntities) -> wire.Spawnings:
        return wire.Spawnings(results=tuple([await self._spawning(each) for each in request.entities]))

    async def _spawning(self, request: wire.SpawnEntity) -> wire.Spawning:
        try:
            return wire.Spawning(name=await self._simulator.spawn(request))
        except RequestRefused as refused:
            return wire.Spawning(name=request.name, code=refused.code, message=refused.message)

    async def _delete(self, request: wire.EntityName) -> Empty:
        await self._simulator.call("delete_entity", "DeleteEntity", {"entity": request.name})
        return Empty()

    async def _entities(self, request: wire.EntityFilter) -> wire.Entities:
        if request != wire.EntityFilter(filter=request.filter):
            raise RequestRefused(Result.FEATURE_UNSUPPORTED, "entities are filtered by their names alone here")
        found = await self._simulator.call("get_entities", "GetEntities", {"filters": {"filter": request.filter}})
        return wire.Entities(names=tuple(sorted(found.entities)))

    async def _state(self, request: wire.EntityName) -> wire.EntityState:
        states = await self._simulator.states()
        if request.name not in states.entities:
            known = listed(states.entities)
            raise RequestRefused(Result.NOT_FOUND, f"there is no entity {request.name!r}: known are {known}")
        return states.of(request.name)

    async def _set_state(self, request: wire.SetEntityState) -> Empty:
        await self._simulator.set_state(request)
        return Empty()

    async def _relative_pose(self, request: wire.RelativePose) -> wire.Pose:
        check_finite("distance", request.distance)
        x, y, yaw = relative(await self._simulator.states(), request.frame, request.parent_frame)
        place = wire.Vector3(x=x + request.distance * math.cos(yaw), y=y + request.distance * math.sin(yaw))
        return wire.Pose(position=place, orientation=wire.Orientation(yaw=yaw))


@asynccontextmanager
async def serving_simulator(
    session: AsyncSession, name: str, system: RosSystem, namespace: str = "/"
) -> AsyncIterator[RosSimulator]:
    """Be a simulator node for as long as the block lasts, by a simulator of a ROS 2 system.

    Args:
        session: Where the node is.
        name: Of the node.
        system: The ROS 2 system.
        namespace: Of the simulator's services.

    Raises:
        InvalidUse: There is no simulator, or it lacks what is needed.
    """
    busy = wire.encode(wire.Refusal(code=Result.OPERATION_FAILED, message="the node is busy: ask again later"))
    async with AsyncExitStack() as stack:
        ros = await stack.enter_async_context(system.node(BRIDGE, namespace))
        simulator = SimulationInterfaces(ros, stack)
        await _find(simulator, system, namespace)
        try:
            features = (await simulator.call("get_simulator_features", "GetSimulatorFeatures", {})).features
            served = RosSimulator(await stack.enter_async_context(opening_world(simulator)), features)
        except RequestRefused as refused:
            raise InvalidUse(f"the simulator cannot be used: {refused.message}") from refused
        key, token = wire.node_command(wire.NAMESPACE, name, "*"), secrets.token_hex(8)
        requests = await stack.enter_async_context(session.answering(key, WAITING, busy))
        await stack.enter_async_context(session.token(wire.node_token(wire.NAMESPACE, name, token)))
        tasks = await stack.enter_async_context(background())
        tasks.start_soon(_answer, served, requests)
        yield served


async def _find(simulator: SimulationInterfaces, system: RosSystem, namespace: str) -> None:
    """Wait until there is what is needed."""
    needed = ("get_simulator_features", *NEEDED)
    try:
        await system.graph.wait_for(lambda _: all(map(simulator.serves, needed)), FOUND_WITHIN)
    except TimeoutError:
        missing = listed(name for name in needed if not simulator.serves(name))
        raise InvalidUse(
            f"there is no simulator with the services of `simulation_interfaces` in {namespace}",
            help=f"services that are missing: {missing}",
        ) from None


async def _answer(simulator: RosSimulator, requests: Mailbox[Request]) -> None:
    """Answer one request after the other, in the order in which they came."""
    async for request in requests:
        await simulator.answer(request)

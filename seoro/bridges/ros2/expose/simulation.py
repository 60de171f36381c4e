"""The simulator as services of ROS `simulation_interfaces`, with the names that simulators use."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass
from functools import partial
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2.action_server import GoalEnd, GoalHandle, Status, serving_action
from seoro.bridges.ros2.expose import entities
from seoro.bridges.ros2.expose.entities import Fields, refused, succeeded
from seoro.bridges.ros2.expose.node import ExposedNode
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.services import Handler, simulation_service_type
from seoro.bridges.wire import Empty, Result
from seoro.errors import BackendRefused

FEATURES: Mapping[str, tuple[int, ...]] = {
    "spawn_entity": (0, 9),
    "delete_entity": (1,),
    "get_named_poses": (2,),
    "get_named_pose_bounds": (3,),
    "get_entities": (4, 8),
    "get_entity_bounds": (5, 6),
    "get_entity_state": (10,),
    "set_entity_state": (11,),
    "get_entity_info": (12,),
    "set_entity_info": (13,),
    "get_spawnables": (14,),
    "reset_simulation": (20, 21, 22, 23),
    "get_simulation_state": (24,),
    "set_simulation_state": (25, 26),
    "step_simulation": (31, 32, 33),
    "load_world": (40,),
    "unload_world": (43,),
    "get_current_world": (44,),
    "get_available_worlds": (45,),
    "spawn_entities": (50,),
}
"""Features of `simulation_interfaces/SimulatorFeatures` by the verbs of a node that provide them."""
STEPS = 50  # steps per request of an action, which can be canceled between requests
ALL_FAILED = 150  # result of `SpawnEntities`: at least one entity was not spawned

Carry = Callable[[Any], Awaitable[Fields]]


@dataclass(frozen=True)
class _Service:
    """A service that is one verb of the node.

    Attributes:
        verb: The verb.
        convert: Converts a request of the service to one of the verb.
        fields: Returns the members of a response besides `result`.
    """

    verb: wire.Verb[Any, Any]
    convert: Callable[[Any], wire.Message] = lambda _request: Empty()
    fields: Callable[[Any], Fields] = lambda _reply: {}


SERVICES: Mapping[str, _Service] = {
    "spawn_entity": _Service(
        wire.SPAWN_ENTITY, entities.spawn_request, lambda spawned: {"entity_name": spawned.name}
    ),
    "delete_entity": _Service(wire.DELETE_ENTITY, entities.entity_name),
    "get_entities": _Service(
        wire.GET_ENTITIES, entities.entity_filter, lambda found: {"entities": list(found.names)}
    ),
    "set_entity_state": _Service(wire.SET_ENTITY_STATE, entities.state_request),
    "get_entity_info": _Service(
        wire.GET_ENTITY_INFO, entities.entity_name, lambda info: {"info": entities.entity_info(info)}
    ),
    "set_entity_info": _Service(wire.SET_ENTITY_INFO, entities.info_request),
    "get_entity_bounds": _Service(wire.GET_ENTITY_BOUNDS, entities.entity_name, entities.bounds_fields),
    "get_named_poses": _Service(
        wire.GET_NAMED_POSES, lambda request: entities.tags_filter(request.tags), entities.named_poses
    ),
    "get_named_pose_bounds": _Service(
        wire.GET_NAMED_POSE_BOUNDS, lambda request: wire.PoseName(name=request.name), entities.bounds_fields
    ),
    "get_spawnables": _Service(
        wire.GET_SPAWNABLES,
        lambda request: wire.GetSpawnables(sources=tuple(request.sources)),
        entities.spawnables,
    ),
    "get_simulation_state": _Service(
        wire.GET_SIMULATION_STATE, fields=lambda found: {"state": {"state": entities.STATES[found.state]}}
    ),
    "set_simulation_state": _Service(wire.SET_SIMULATION_STATE, entities.simulation_state_request),
    "step_simulation": _Service(
        wire.STEP_SIMULATION, lambda request: wire.StepSimulation(steps=int(request.steps))
    ),
    "reset_simulation": _Service(
        wire.RESET_SIMULATION, lambda request: wire.ResetSimulation(scope=int(request.scope))
    ),
    "get_current_world": _Service(wire.GET_CURRENT_WORLD, fields=entities.current_world),
    "get_available_worlds": _Service(
        wire.GET_AVAILABLE_WORLDS, entities.worlds_request, entities.available_worlds
    ),
}
"""Services without further requests to the node; see `SimulationServices` for the others."""


class SimulationServices:
    """Handlers of the services.

    Args:
        node: The simulator node.
    """

    def __init__(self, node: ExposedNode) -> None:
        self._node = node

    def all(self) -> dict[str, Carry]:
        """Return the handlers of all services, by name."""
        return {
            **{name: partial(self._call, service) for name, service in SERVICES.items()},
            "get_simulator_features": self._features,
            "spawn_entities": self._spawn_many,
            "get_entities_states": self._states,
            "get_entity_state": self._state,
            "load_world": self._load_world,
            "unload_world": self._unload_world,
        }

    async def _call(self, service: _Service, request: Any) -> Fields:
        reply = await self._node.ask(service.verb, service.convert(request))
        return {"result": succeeded(), **service.fields(reply)}

    async def _features(self, _: Any) -> Fields:
        found = await self._node.ask(wire.GET_SIMULATOR_FEATURES, Empty())
        numbers = [number for verb in found.features for number in FEATURES.get(verb, ())]
        about = f"seoro {found.version}, {found.engine} {found.engine_version}"
        formats = list(found.spawn_formats)
        return {"features": {"features": sorted(numbers), "spawn_formats": formats, "custom_info": about}}

    async def _spawn_many(self, request: Any) -> Fields:
        wanted = tuple(entities.spawn_request(each) for each in request.spawn_requests)
        spawned = (await self._node.ask(wire.SPAWN_ENTITIES, wire.SpawnEntities(entities=wanted))).results
        results = [
            {
                "result": succeeded() if each.code == Result.OK else refused(each.code, each.message),
                "entity_name": each.name,
            }
            for each in spawned
        ]
        failed = sum(each.code != Result.OK for each in spawned)
        message = f"{failed} of {len(spawned)} entities were not spawned"
        return {"result": refused(ALL_FAILED, message) if failed else succeeded(), "results": results}

    async def _states(self, request: Any) -> Fields:
        found = await self._node.ask(wire.GET_ENTITIES_STATES, entities.entity_filter(request))
        time = await self._time()
        states = [entities.entity_state(state, time) for state in found.states]
        return {"result": succeeded(), "entities": list(found.names), "states": states}

    async def _state(self, request: Any) -> Fields:
        state = await self._node.ask(wire.GET_ENTITY_STATE, entities.entity_name(request))
        return {"result": succeeded(), "state": entities.entity_state(state, await self._time())}

    async def _time(self) -> float:
        return (await self._node.ask(wire.GET_SIMULATION_STATE, Empty())).time

    async def _load_world(self, request: Any) -> Fields:
        uri = request.world_resource.uri
        if request.world_resource.resource_string:
            raise BackendRefused("worlds are loaded by name or by file path", Result.FEATURE_UNSUPPORTED)
        features = await self._node.ask(wire.LOAD_WORLD, wire.LoadWorld(world=uri.removeprefix("file://")))
        await self._node.worlds.replace()
        return {"result": succeeded(), "world": entities.world_resource(features.world, uri)}

    async def _unload_world(self, _: Any) -> Fields:
        await self._node.ask(wire.UNLOAD_WORLD, Empty())
        await self._node.worlds.replace()
        return {"result": succeeded()}

    async def simulate_steps(self, goal: GoalHandle) -> GoalEnd:
        """Execute a goal: simulate steps in portions, and report their number."""
        wanted, made = int(goal.goal.steps), 0
        try:
            while made < wanted:
                count = min(wanted - made, STEPS)
                await self._node.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=count))
                made += count
                goal.publish_feedback({"completed_steps": made, "remaining_steps": wanted - made})
        except BackendRefused as error:
            return GoalEnd(Status.ABORTED, {"result": refused(error.code, str(error))})
        return GoalEnd(Status.SUCCEEDED, {"result": succeeded()})


@asynccontextmanager
async def serving_simulation(ros: RosNode, node: ExposedNode) -> AsyncIterator[None]:
    """Serve `simulation_interfaces` in the namespace of a ROS node during the block."""
    services = SimulationServices(node)
    async with AsyncExitStack() as stack:
        stepping = serving_action(
            ros, "simulate_steps", "simulation_interfaces/action/SimulateSteps", services.simulate_steps
        )
        await stack.enter_async_context(stepping)
        for name, carry_out in services.all().items():
            service = ros.serving(name, simulation_service_type(name), _with_result(carry_out))
            await stack.enter_async_context(service)
        yield


def _with_result(carry_out: Carry) -> Handler:
    """Wrap a handler so that a refusal becomes the `result` of the response."""

    async def handle(request: Message) -> Fields:
        try:
            return await carry_out(request)
        except BackendRefused as error:
            return {"result": refused(error.code, str(error))}

    return handle

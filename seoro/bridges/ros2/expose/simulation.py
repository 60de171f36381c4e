"""The simulator as the services of ROS `simulation_interfaces`, by the names that simulators give them."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.action_server import GoalEnd, ServedGoal, Status, serving_action
from seoro.bridges.ros2.expose import entities
from seoro.bridges.ros2.expose.entities import Fields, done, refused
from seoro.bridges.ros2.expose.node import ExposedNode
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.services import Handler
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
"""The features of `simulation_interfaces/SimulatorFeatures` that verbs of a node are."""
STEPS = 50  # that are made at a time for an action, which can be called off between
ALL_FAILED = 150  # of `SpawnEntities`: at least one entity was not spawned

Carry = Callable[[Any], Awaitable[Fields]]


class SimulationServices:
    """What the services do.

    Args:
        node: The simulator node.
    """

    def __init__(self, node: ExposedNode) -> None:
        self._node = node

    def all(self) -> dict[str, tuple[str, Carry]]:
        """All services: their types and what carries them out, by name."""
        return {
            "get_simulator_features": ("GetSimulatorFeatures", self._features),
            "spawn_entity": ("SpawnEntity", self._spawn),
            "spawn_entities": ("SpawnEntities", self._spawn_many),
            "delete_entity": ("DeleteEntity", self._delete),
            "get_entities": ("GetEntities", self._entities),
            "get_entities_states": ("GetEntitiesStates", self._states),
            "get_entity_state": ("GetEntityState", self._state),
            "set_entity_state": ("SetEntityState", self._set_state),
            "get_entity_info": ("GetEntityInfo", self._info),
            "set_entity_info": ("SetEntityInfo", self._set_info),
            "get_entity_bounds": ("GetEntityBounds", self._bounds),
            "get_named_poses": ("GetNamedPoses", self._named_poses),
            "get_named_pose_bounds": ("GetNamedPoseBounds", self._room),
            "get_spawnables": ("GetSpawnables", self._spawnables),
            "get_simulation_state": ("GetSimulationState", self._simulation_state),
            "set_simulation_state": ("SetSimulationState", self._set_simulation_state),
            "step_simulation": ("StepSimulation", self._step),
            "reset_simulation": ("ResetSimulation", self._reset),
            "load_world": ("LoadWorld", self._load_world),
            "unload_world": ("UnloadWorld", self._unload_world),
            "get_current_world": ("GetCurrentWorld", self._world),
            "get_available_worlds": ("GetAvailableWorlds", self._worlds),
        }

    async def _ask(self, verb: wire.Verb[wire.Q, wire.A], request: wire.Q) -> wire.A:
        return await self._node.ask(verb, request)

    async def _features(self, _: Any) -> Fields:
        features = await self._ask(wire.GET_SIMULATOR_FEATURES, Empty())
        numbers = [number for verb in features.features for number in FEATURES.get(verb, ())]
        about = f"seoro {features.version}, {features.engine} {features.engine_version}"
        told = {"features": sorted(numbers), "spawn_formats": list(features.spawn_formats), "custom_info": about}
        return {"features": told}

    # ------------------------------------------------------------ entities

    async def _spawn(self, request: Any) -> Fields:
        name = (await self._ask(wire.SPAWN_ENTITY, entities.spawn_request(request))).name
        return {"result": done(), "entity_name": name}

    async def _spawn_many(self, request: Any) -> Fields:
        wanted = tuple(entities.spawn_request(each) for each in request.spawn_requests)
        spawned = (await self._ask(wire.SPAWN_ENTITIES, wire.SpawnEntities(entities=wanted))).results
        results: list[Fields] = [
            {
                "result": done() if each.code == Result.OK else refused(each.code, each.message),
                "entity_name": each.name,
            }
            for each in spawned
        ]
        failed = sum(each.code != Result.OK for each in spawned)
        message = f"{failed} of {len(spawned)} entities were not spawned"
        return {"result": refused(ALL_FAILED, message) if failed else done(), "results": results}

    async def _delete(self, request: Any) -> Fields:
        await self._ask(wire.DELETE_ENTITY, wire.EntityName(name=request.entity))
        return {"result": done()}

    async def _entities(self, request: Any) -> Fields:
        found = await self._ask(wire.GET_ENTITIES, entities.entity_filter(request.filters))
        return {"result": done(), "entities": list(found.names)}

    async def _states(self, request: Any) -> Fields:
        found = await self._ask(wire.GET_ENTITIES_STATES, entities.entity_filter(request.filters))
        time = await self._time()
        states = [entities.entity_state(state, time) for state in found.states]
        return {"result": done(), "entities": list(found.names), "states": states}

    async def _time(self) -> float:
        return (await self._ask(wire.GET_SIMULATION_STATE, Empty())).time

    async def _state(self, request: Any) -> Fields:
        state = await self._ask(wire.GET_ENTITY_STATE, wire.EntityName(name=request.entity))
        return {"result": done(), "state": entities.entity_state(state, await self._time())}

    async def _set_state(self, request: Any) -> Fields:
        await self._ask(wire.SET_ENTITY_STATE, entities.state_request(request))
        return {"result": done()}

    async def _info(self, request: Any) -> Fields:
        info = await self._ask(wire.GET_ENTITY_INFO, wire.EntityName(name=request.entity))
        return {"result": done(), "info": entities.entity_info(info)}

    async def _set_info(self, request: Any) -> Fields:
        info = wire.EntityInfo(
            category=int(request.info.category.category),
            description=request.info.description,
            tags=tuple(request.info.tags),
        )
        await self._ask(wire.SET_ENTITY_INFO, wire.SetEntityInfo(name=request.entity, info=info))
        return {"result": done()}

    async def _bounds(self, request: Any) -> Fields:
        reach = await self._ask(wire.GET_ENTITY_BOUNDS, wire.EntityName(name=request.entity))
        return {"result": done(), "bounds": entities.bounds_message(reach.bounds)}

    async def _named_poses(self, request: Any) -> Fields:
        found = await self._ask(wire.GET_NAMED_POSES, entities.tags_filter(request.tags))
        poses = [
            {
                "name": each.name,
                "description": each.description,
                "tags": list(each.tags),
                "pose": geometry.pose_message(each.pose),
            }
            for each in found.poses
        ]
        return {"result": done(), "poses": poses}

    async def _room(self, request: Any) -> Fields:
        room = await self._ask(wire.GET_NAMED_POSE_BOUNDS, wire.PoseName(name=request.name))
        return {"result": done(), "bounds": entities.bounds_message(room.bounds)}

    async def _spawnables(self, request: Any) -> Fields:
        found = await self._ask(wire.GET_SPAWNABLES, wire.GetSpawnables(sources=tuple(request.sources)))
        spawnables = [
            {
                "entity_resource": {"uri": each.uri},
                "description": each.description,
                "spawn_bounds": entities.bounds_message(each.bounds),
            }
            for each in found.spawnables
        ]
        return {"result": {**done(), "error_message": found.message}, "spawnables": spawnables}

    # ------------------------------------------------------------ the whole

    async def simulate_steps(self, goal: ServedGoal) -> GoalEnd:
        """Make steps, some at a time, and tell how many."""
        wanted, made = int(goal.goal.steps), 0
        try:
            while made < wanted:
                count = min(wanted - made, STEPS)
                await self._ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=count))
                made += count
                goal.tell({"completed_steps": made, "remaining_steps": wanted - made})
        except BackendRefused as error:
            return GoalEnd(Status.ABORTED, {"result": refused(error.code, str(error))})
        return GoalEnd(Status.SUCCEEDED, {"result": done()})

    async def _simulation_state(self, _: Any) -> Fields:
        state = (await self._ask(wire.GET_SIMULATION_STATE, Empty())).state
        return {"state": {"state": entities.STATES[state]}, "result": done()}

    async def _set_simulation_state(self, request: Any) -> Fields:
        wanted = next((state for state, number in entities.STATES.items() if number == request.state.state), None)
        if wanted is None:
            raise BackendRefused(
                f"there is no way to the state {request.state.state}: there is one to 0 (stopped), 1 (playing) "
                "and 2 (paused)",
                Result.FEATURE_UNSUPPORTED,
            )
        await self._ask(wire.SET_SIMULATION_STATE, wire.SetSimulationState(state=wanted))
        return {"result": done()}

    async def _step(self, request: Any) -> Fields:
        await self._ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=int(request.steps)))
        return {"result": done()}

    async def _reset(self, request: Any) -> Fields:
        await self._ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=int(request.scope)))
        return {"result": done()}

    async def _load_world(self, request: Any) -> Fields:
        if request.world_resource.resource_string:
            raise BackendRefused(
                "worlds are loaded by name or by the path of their file", Result.FEATURE_UNSUPPORTED
            )
        name = request.world_resource.uri.removeprefix("file://")
        features = await self._ask(wire.LOAD_WORLD, wire.LoadWorld(world=name))
        await self._node.worlds.change()
        return {"result": done(), "world": _described(features.world, request.world_resource.uri)}

    async def _unload_world(self, _: Any) -> Fields:
        await self._ask(wire.UNLOAD_WORLD, Empty())
        await self._node.worlds.change()
        return {"result": done()}

    async def _world(self, _: Any) -> Fields:
        world = await self._ask(wire.GET_CURRENT_WORLD, Empty())
        return {"result": done(), "world": _described(world.name, world.source, world.description, world.tags)}

    async def _worlds(self, request: Any) -> Fields:
        tags = entities.tags_filter(request.filter)
        wanted = wire.GetAvailableWorlds(tags=tags, sources=tuple(request.additional_sources))
        found = await self._ask(wire.GET_AVAILABLE_WORLDS, wanted)
        result = done() if not found.message else {**done(), "error_message": found.message}
        worlds = [_described(each.source, each.source, each.description, each.tags) for each in found.worlds]
        return {"result": result, "worlds": worlds}


def _described(name: str, uri: str, description: str = "", tags: Sequence[str] = ()) -> Fields:
    """A `simulation_interfaces/WorldResource`."""
    return {"name": name, "world_resource": {"uri": uri}, "description": description, "tags": list(tags)}


@asynccontextmanager
async def serving_simulation(ros: RosNode, node: ExposedNode) -> AsyncIterator[None]:
    """Serve `simulation_interfaces` by a ROS node, in its namespace, for as long as the block lasts."""
    services = SimulationServices(node)
    async with AsyncExitStack() as stack:
        stepping = serving_action(
            ros, "simulate_steps", "simulation_interfaces/action/SimulateSteps", services.simulate_steps
        )
        await stack.enter_async_context(stepping)
        for name, (kind, carry_out) in services.all().items():
            service = ros.serving(name, f"simulation_interfaces/srv/{kind}", _with_result(carry_out))
            await stack.enter_async_context(service)
        yield


def _with_result(carry_out: Carry) -> Handler:
    """A handler that says in the response's `result` why something was not carried out."""

    async def handle(request: Message) -> Fields:
        try:
            return await carry_out(request)
        except BackendRefused as error:
            return {"result": refused(error.code, str(error))}

    return handle

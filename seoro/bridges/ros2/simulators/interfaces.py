"""Client of the services of a simulator (`simulation_interfaces`), with the messages of the protocol of nodes."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.errors import CallFailed, DefinitionMismatch, WrongType
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.services import Client, simulation_service_type
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite
from seoro.errors import SeoroError

MAP = "map"
PLAYING, PAUSED = 1, 2  # simulation_interfaces/msg/SimulationState
TIMEOUT = 60.0  # [s] for a response; a simulator may load a world, or make many steps


@dataclass(frozen=True)
class States:
    """States of the entities, as messages by name, and their time [s]."""

    time: float
    entities: Mapping[str, Any]

    def of(self, name: str) -> wire.EntityState:
        """Return the state of one entity.

        Raises:
            RequestRefused: The state is invalid.
        """
        state = self.entities[name]
        try:
            pose, twist = geometry.pose(state.pose), geometry.twist(state.twist)
        except ValueError as error:
            message = f"invalid state of the entity {name!r}: {error}"
            raise RequestRefused(Result.OPERATION_FAILED, message) from error
        for part in (pose.position, twist.linear, twist.angular):
            check_finite(f"state of the entity {name!r}", part.x, part.y, part.z)
        return wire.EntityState(pose=pose, twist=twist)


class SimulationInterfaces:
    """Client of the services of a simulator.

    Args:
        ros: ROS node in the namespace of the services.
        stack: Stack that closes the clients.
    """

    def __init__(self, ros: RosNode, stack: AsyncExitStack) -> None:
        self._ros = ros
        self._stack = stack
        self._clients: dict[str, Client] = {}

    def serves(self, service: str) -> bool:
        """Return whether the simulator has a service."""
        return bool(self._ros.graph.servers(self._ros.resolve(service)))

    async def call(self, service: str, request: Mapping[str, Any] = MappingProxyType({})) -> Any:
        """Call a service, given by its name.

        Raises:
            RequestRefused: The simulator refuses the request or does not respond, or the service has another type.
        """
        try:
            if service not in self._clients:
                calling = self._ros.calling(service, simulation_service_type(service))
                self._clients[service] = await self._stack.enter_async_context(calling)
            response = await self._clients[service].call(request, TIMEOUT)
        except (CallFailed, WrongType, DefinitionMismatch) as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error
        except SeoroError as error:
            raise RequestRefused(Result.OPERATION_FAILED, f"cannot call `{service}`: {error}") from error
        result = getattr(response, "result", None)
        if result is not None and result.result != Result.OK:
            reason = result.error_message or f"result {result.result}"
            raise RequestRefused(int(result.result), f"the simulator refuses `{service}`: {reason}")
        return response

    async def states(self) -> States:
        """Return the states of all entities.

        Raises:
            RequestRefused: Some entities have no state.
        """
        response = await self.call("get_entities_states")
        names, states = response.entities, response.states
        if len(names) != len(states):
            message = f"`get_entities_states` returns {len(names)} entities and {len(states)} states"
            raise RequestRefused(Result.OPERATION_FAILED, message)
        times = [geometry.seconds(state.header.stamp) for state in states]
        return States(max(times, default=0.0), dict(zip(names, states, strict=True)))

    async def step(self, steps: int) -> None:
        """Make physics steps."""
        await self.call("step_simulation", {"steps": steps})

    async def is_playing(self) -> bool:
        """Return whether the simulation is playing."""
        state = (await self.call("get_simulation_state")).state.state
        return bool(state == PLAYING)

    async def pause(self) -> None:
        """Pause the simulation if it is playing."""
        if await self.is_playing():
            await self._set_simulation_state(PAUSED)

    async def play(self) -> None:
        """Play the simulation."""
        await self._set_simulation_state(PLAYING)

    async def _set_simulation_state(self, state: int) -> None:
        await self.call("set_simulation_state", {"state": {"state": state}})

    async def spawn(self, request: wire.SpawnEntity) -> str:
        """Spawn an entity, and return its name."""
        spawned = await self.call("spawn_entity", _spawn_request(request))
        return str(spawned.entity_name) or request.name

    async def set_state(self, request: wire.SetEntityState) -> None:
        """Set the pose or the velocity of an entity."""
        state: dict[str, Any] = {"header": geometry.header(MAP, 0.0)}
        if request.pose is not None:
            state["pose"] = geometry.pose_message(request.pose)
        if request.twist is not None:
            state["twist"] = geometry.twist_message(request.twist)
        wanted = {"set_pose": request.pose is not None, "set_twist": request.twist is not None}
        await self.call("set_entity_state", {"entity": request.name, "state": state, **wanted})


def _spawn_request(request: wire.SpawnEntity) -> Mapping[str, Any]:
    """Make a `SpawnEntity` request, preferably with the text of the model, which needs no files."""
    text = request.resource_string
    return {
        "name": request.name,
        "allow_renaming": request.allow_renaming,
        "entity_resource": {"resource_string": text} if text else {"uri": request.uri},
        "initial_pose": {
            "header": geometry.header(MAP, 0.0),
            "pose": geometry.pose_message(request.initial_pose),
        },
    }

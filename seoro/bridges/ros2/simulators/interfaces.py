"""The services of a simulator (`simulation_interfaces`), called with the messages of seoro's wire."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.errors import CallFailed, DefinitionMismatch, WrongType
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.services import Client
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused, check_finite
from seoro.errors import SeoroError

MAP = "map"
STOPPED, PLAYING, PAUSED = 0, 1, 2  # of `simulation_interfaces/SimulationState`
TIMEOUT = 60.0  # [s] for a response; a simulator may load a world, or make many steps
FOUND_WITHIN = 5.0  # [s]
NEEDED = {
    "get_entities_states": "GetEntitiesStates",
    "step_simulation": "StepSimulation",
    "set_simulation_state": "SetSimulationState",
    "get_simulation_state": "GetSimulationState",
}
"""Services that there have to be."""


@dataclass(frozen=True)
class States:
    """Where the entities are, as messages by name, and when that was [s]."""

    time: float
    entities: Mapping[str, Any]

    def of(self, name: str) -> wire.EntityState:
        """Where one of them is.

        Raises:
            RequestRefused: That is not told in numbers that can be used.
        """
        state = self.entities[name]
        try:
            pose, twist = geometry.pose(state.pose), geometry.twist(state.twist)
        except ValueError as error:
            message = f"the state of the entity {name!r} cannot be used: {error}"
            raise RequestRefused(Result.OPERATION_FAILED, message) from error
        for part in (pose.position, twist.linear, twist.angular):
            check_finite(f"state of the entity {name!r}", part.x, part.y, part.z)
        return wire.EntityState(pose=pose, twist=twist)


class SimulationInterfaces:
    """The services of a simulator.

    Args:
        ros: A ROS node in the namespace of the services.
        stack: Closes the clients.
    """

    def __init__(self, ros: RosNode, stack: AsyncExitStack) -> None:
        self._ros = ros
        self._stack = stack
        self._clients: dict[str, Client] = {}

    def serves(self, service: str) -> bool:
        """Whether the simulator has a service."""
        return bool(self._ros.graph.servers(self._ros.resolve(service)))

    async def call(self, service: str, kind: str, request: Mapping[str, Any]) -> Any:
        """Call a service.

        Args:
            service: Its name.
            kind: Its type, without the package.
            request: The request.

        Raises:
            RequestRefused: The simulator said no, does not respond, or serves something else by that name.
        """
        try:
            if service not in self._clients:
                calling = self._ros.calling(service, f"simulation_interfaces/srv/{kind}")
                self._clients[service] = await self._stack.enter_async_context(calling)
            response = await self._clients[service].call(request, TIMEOUT)
        except (CallFailed, WrongType, DefinitionMismatch) as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error
        except SeoroError as error:
            raise RequestRefused(Result.OPERATION_FAILED, f"`{service}` cannot be used: {error}") from error
        result = getattr(response, "result", None)
        if result is not None and result.result != Result.OK:
            reason = result.error_message or f"the result is {result.result}"
            raise RequestRefused(int(result.result), f"`{service}` was refused: {reason}")
        return response

    async def states(self) -> States:
        """Where all entities are.

        Raises:
            RequestRefused: Also when there is not a state for each.
        """
        response = await self.call("get_entities_states", "GetEntitiesStates", {})
        names, states = response.entities, response.states
        if len(names) != len(states):
            message = f"`get_entities_states` names {len(names)} entities and has {len(states)} states"
            raise RequestRefused(Result.OPERATION_FAILED, message)
        times = [geometry.seconds(state.header.stamp) for state in states]
        return States(max(times, default=0.0), dict(zip(names, states, strict=True)))

    async def step(self, steps: int) -> None:
        """Make physics steps; responds when they are made."""
        await self.call("step_simulation", "StepSimulation", {"steps": steps})

    async def plays(self) -> bool:
        """Whether time passes by itself."""
        state = (await self.call("get_simulation_state", "GetSimulationState", {})).state.state
        return bool(state == PLAYING)

    async def pause(self) -> None:
        """Let no time pass but by steps."""
        if await self.plays():
            await self._go_into(PAUSED)

    async def play(self) -> None:
        """Let time pass by itself."""
        await self._go_into(PLAYING)

    async def _go_into(self, state: int) -> None:
        await self.call("set_simulation_state", "SetSimulationState", {"state": {"state": state}})

    async def spawn(self, request: wire.SpawnEntity) -> str:
        """Spawn an entity; returns the name it got."""
        spawned = await self.call("spawn_entity", "SpawnEntity", _spawning(request))
        return str(spawned.entity_name) or request.name

    async def set_state(self, request: wire.SetEntityState) -> None:
        """Put an entity somewhere."""
        state: dict[str, Any] = {"header": geometry.header(MAP, 0.0)}
        if request.pose is not None:
            state["pose"] = geometry.pose_message(request.pose)
        if request.twist is not None:
            state["twist"] = geometry.twist_message(request.twist)
        wanted = {"set_pose": request.pose is not None, "set_twist": request.twist is not None}
        await self.call("set_entity_state", "SetEntityState", {"entity": request.name, "state": state, **wanted})


def _spawning(request: wire.SpawnEntity) -> Mapping[str, Any]:
    """A request `SpawnEntity`: by the text of the model where there is one, which needs no files on their side."""
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

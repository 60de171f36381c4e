"""The services of a simulator (`simulation_interfaces`), called with the messages of seoro's wire."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AsyncExitStack
from dataclasses import dataclass
from typing import Any

from seoro.bridges import wire
from seoro.bridges.ros2 import geometry
from seoro.bridges.ros2.errors import CallFailed
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.services import Client
from seoro.bridges.wire import Result
from seoro.bridges.wire.refusal import RequestRefused

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
    """Where the entities are, by name, and when that was [s]."""

    time: float
    entities: Mapping[str, wire.EntityState]


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
            RequestRefused: The simulator said no, or does not respond.
        """
        if service not in self._clients:
            calling = self._ros.calling(service, f"simulation_interfaces/srv/{kind}")
            self._clients[service] = await self._stack.enter_async_context(calling)
        try:
            response = await self._clients[service].call(request, TIMEOUT)
        except CallFailed as error:
            raise RequestRefused(Result.OPERATION_FAILED, str(error)) from error
        result = getattr(response, "result", None)
        if result is not None and result.result != Result.OK:
            message = result.error_message or f"{service} was refused with the result {result.result}"
            raise RequestRefused(int(result.result), message)
        return response

    async def states(self) -> States:
        """Where all entities are."""
        response = await self.call("get_entities_states", "GetEntitiesStates", {})
        times = [geometry.seconds(state.header.stamp) for state in response.states]
        entities = {
            name: wire.EntityState(pose=geometry.pose(state.pose), twist=geometry.twist(state.twist))
            for name, state in zip(response.entities, response.states, strict=True)
        }
        return States(max(times, default=0.0), entities)

    async def step(self, steps: int) -> None:
        """Make physics steps; responds when they are made."""
        await self.call("step_simulation", "StepSimulation", {"steps": steps})

    async def pause(self) -> None:
        """Let no time pass but by steps."""
        state = (await self.call("get_simulation_state", "GetSimulationState", {})).state.state
        if state == PLAYING:
            await self.call("set_simulation_state", "SetSimulationState", {"state": {"state": PAUSED}})

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

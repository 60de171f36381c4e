"""The simulated world; see `Simulation`."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.bridges import wire
from seoro.bridges.models import ModelNotFound, ModelPath
from seoro.bridges.sim.messages import twist_message
from seoro.bridges.sim.requests import NodeAddress, Requests
from seoro.bridges.sim.rules import check_pose
from seoro.errors import BackendRefused
from seoro.robotics.geometry import Pose3D, Velocity6D

PROP = "prop://"  # scheme of copies of props of the world, which only the node knows
SPAWN_TIMEOUT = 60.0  # [s]


class WorldRequests(Requests):
    """The capability `Simulation` of a node.

    Args:
        address: Address of the node.
        models: Search path of models to spawn.
    """

    def __init__(self, address: NodeAddress, models: ModelPath) -> None:
        super().__init__(address)
        self._models = models

    async def spawn_entity(self, name: str, model: str, pose: Pose3D, *, allow_renaming: bool = False) -> str:
        """See `Simulation`."""
        return (await self.ask(wire.SPAWN_ENTITY, self._entity(name, model, pose, allow_renaming))).name

    async def spawn_entities(self, entities: Sequence[tuple[str, str, Pose3D]]) -> None:
        """See `Simulation`."""
        texts = tuple(self._entity(name, model, pose, allow_renaming=False) for name, model, pose in entities)
        answer = await self.ask(wire.SPAWN_ENTITIES, wire.SpawnEntities(entities=texts), SPAWN_TIMEOUT)
        refused = [result for result in answer.results if result.code != wire.Result.OK]
        if refused:
            more = f"; {len(refused) - 1} others of {len(texts)} as well" if len(refused) > 1 else ""
            raise BackendRefused(
                f"'{refused[0].name}' was not spawned: {refused[0].message}{more}", refused[0].code
            )

    def _entity(self, name: str, model: str, pose: Pose3D, allow_renaming: bool) -> wire.SpawnEntity:
        text = "" if model.startswith(PROP) else self._text(model)
        return wire.SpawnEntity(
            name=name, uri=model, resource_string=text, initial_pose=pose, allow_renaming=allow_renaming
        )

    def _text(self, model: str) -> str:
        try:
            text = self._models.read(model)
        except ModelNotFound as error:
            raise BackendRefused(str(error), wire.SpawnResult.NO_RESOURCE) from error
        if not text:
            raise BackendRefused(f"the model '{model}' is empty", wire.SpawnResult.NO_RESOURCE)
        return text

    async def relative_pose(self, frame: str, parent_frame: str, distance: float) -> Pose3D:
        """See `Simulation`."""
        request = wire.RelativePose(frame=frame, parent_frame=parent_frame, distance=distance)
        found = await self.ask(wire.GET_RELATIVE_POSE, request)
        pose = Pose3D(found.position, found.orientation)
        check_pose(self.name, f"the pose of '{frame:.100}' in '{parent_frame:.100}'", pose)
        return pose

    async def delete_entity(self, name: str) -> None:
        """See `Simulation`."""
        await self.ask(wire.DELETE_ENTITY, wire.EntityName(name=name))

    async def entities(self) -> tuple[str, ...]:
        """See `Simulation`."""
        return (await self.ask(wire.GET_ENTITIES, wire.EntityFilter())).names

    async def set_entity_state(self, name: str, pose: Pose3D, velocity: Velocity6D) -> None:
        """See `Simulation`."""
        request = wire.SetEntityState(name=name, pose=pose, twist=twist_message(velocity))
        await self.ask(wire.SET_ENTITY_STATE, request)

    async def step_simulation(self, steps: int) -> None:
        """See `Simulation`."""
        await self.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=steps))

    async def reset_simulation(self) -> None:
        """See `Simulation`. The clock of the simulator is that of the run, so it is not reset."""
        scope = wire.ResetScope.STATE | wire.ResetScope.SPAWNED
        await self.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=scope))

"""Simulator node as a backend: assignment of its robots to actors, start and end of a run."""

from __future__ import annotations

from collections.abc import Sequence

from seoro.bridges import wire
from seoro.bridges.models import ModelPath
from seoro.bridges.sim.advance import GRANT_TIMEOUT, AdvanceRequests
from seoro.bridges.sim.buildings import BuildingRequests
from seoro.bridges.sim.capabilities import CAPABILITIES, reason_unserved
from seoro.bridges.sim.devices import DeviceRequests
from seoro.bridges.sim.measures import MeasureRequests
from seoro.bridges.sim.people import PeopleRequests
from seoro.bridges.sim.requests import NodeAddress
from seoro.bridges.sim.world import WorldRequests
from seoro.files.inputs import resolved
from seoro.files.path_mapping import Locate
from seoro.files.world_names import WorldName
from seoro.runtime.contracts.backends import WARNING, EventHandler, LossHandler
from seoro.runtime.contracts.sensors import Faults

ANY_ACTOR = "osc_actor"


class SimulatorNode(
    DeviceRequests, PeopleRequests, BuildingRequests, MeasureRequests, WorldRequests, AdvanceRequests
):
    """A simulator node.

    Args:
        address: Address of the node.
        models: Folders in which models to spawn are looked up.
        features: Features of the node when its world was loaded.
    """

    def __init__(self, address: NodeAddress, models: ModelPath, features: wire.SimulatorFeatures) -> None:
        super().__init__(address, models)
        self.features = features
        self._taken: dict[str, str] = {}  # assigned robots, with the types of their actors
        self.set_clock(features)

    @property
    def robots(self) -> Sequence[wire.RobotInfo]:
        """Robots of its world."""
        return self.features.robots

    def serves(self, contract: type) -> bool:
        """Whether the node serves all verbs of a contract."""
        return not self.missing_verbs(contract)

    def missing_verbs(self, contract: type) -> tuple[str, ...]:
        """Return the names of the verbs of a contract that the node does not serve."""
        needed = CAPABILITIES.get(contract, ())
        return tuple(verb.name for verb in needed if verb.name not in self.features.features)

    def reason_missing(self, contract: type, robot: str) -> str:
        """See `Selective`."""
        return reason_unserved(contract, self.features.features, "it")

    def senses_contacts(self, robot: str) -> bool:
        """See `ContactSensing`."""
        return any(each.senses_contacts for each in self.features.robots if each.name == robot)

    def reserve(self, robot: wire.RobotInfo) -> None:
        """Exclude a robot from `assign_robot`: the user has assigned it."""
        self._taken[robot.name] = robot.kinds[0]

    def assign_robot(self, actor: str, types: Sequence[str]) -> str | None:
        """Assign the robot with the actor's name, else the first free one that matches the actor's type.

        Actors of the base type `osc_actor` are assigned by name only.
        """
        free = [robot for robot in self.features.robots if robot.name not in self._taken]
        fitting = [robot for robot in free if types[0] in robot.kinds]
        named = next((robot for robot in fitting if robot.name == actor), None)
        chosen = named or (next(iter(fitting), None) if types[0] != ANY_ACTOR else None)
        if chosen is None:
            return None
        self._taken[chosen.name] = types[0]
        return chosen.name

    async def start_run(self, on_event: EventHandler, on_lost: LossHandler) -> None:
        """See `Backend`. Warnings of the node are reported, too."""
        for warning in self.features.warnings:
            on_event(WARNING, {"message": warning})
        await super().start_run(on_event, on_lost)

    async def artifacts(self) -> tuple[wire.Artifact, ...]:
        """Return the artifacts of the run so far."""
        shown = (await self.ask(wire.GET_ARTIFACTS, wire.Empty(), GRANT_TIMEOUT)).artifacts
        return (*shown, *self.saved_snapshots())

    async def load_world(self, world: str, seed: int) -> None:
        """Load a world at time zero, without assigned robots."""
        self.features = await self.ask(wire.LOAD_WORLD, wire.LoadWorld(world=world, seed=seed), GRANT_TIMEOUT)
        self._taken.clear()
        self.set_clock(self.features)

    async def change_world(self, world: str) -> None:
        """See `Worlds`."""
        request = wire.ChangeWorld(world=_portable_path(world, self._models.locate), robots=self._taken)
        self.features = await self.ask(wire.CHANGE_WORLD, request, GRANT_TIMEOUT)

    async def begin_from(self, snapshot: wire.Snapshot, seed: int) -> None:
        """Start from a snapshot at time zero, without assigned robots."""
        await self._restore(wire.RestoreState(snapshot=snapshot, purpose=wire.Purpose.BEGIN, seed=seed))
        self._taken.clear()
        self.set_clock(self.features)

    async def end_run(self) -> None:
        """See `Backend`."""
        for robot in self.features.robots:
            await self.ask(wire.STOP_ROBOT, wire.StopRobot(robot=robot.name))

    async def clear(self) -> None:
        """Remove all effects of the run: goals, watches, faults, motions and spawned entities.

        This includes the effects of requests without a received reply.
        """
        await self.end_run()
        for number in tuple(self._reporters):  # also of goals, which have ended with `end_run`
            await self.cancel_watch(number)
        if self.serves(Faults):
            for robot in self.features.robots:
                await self.clear_faults(robot.name, "")
        await self.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.SPAWNED))


def _portable_path(world: str, locate: Locate) -> str:
    """Return the name of a world, or the absolute path of its file: the node may run in another folder."""
    return WorldName.parse(world).located(lambda path: resolved(locate(path)))

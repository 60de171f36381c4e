"""A simulator node as a backend: which actors live in it, the beginning and the end of a run."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from seoro.bridges import wire
from seoro.bridges.models import ModelPath
from seoro.bridges.sim.arms import ArmRequests
from seoro.bridges.sim.cameras import CameraRequests
from seoro.bridges.sim.driving import DrivingRequests
from seoro.bridges.sim.faults import FaultRequests
from seoro.bridges.sim.levels import lacking
from seoro.bridges.sim.localisation import LocalisationRequests
from seoro.bridges.sim.mobile import MobileRequests
from seoro.bridges.sim.passing import GRANT_TIMEOUT, PassingRequests
from seoro.bridges.sim.requests import NodeAddress
from seoro.bridges.sim.sensors import SensorRequests
from seoro.bridges.sim.snapshots import SnapshotRequests
from seoro.bridges.sim.world import WorldRequests
from seoro.input_files import resolved
from seoro.located import Locate
from seoro.runtime.capabilities import Faults
from seoro.runtime.contracts import WARNING, Happened, Lost

ANYTHING = "osc_actor"
WORLD_FILES = frozenset({".yaml", ".yml"})


class SimulatorNode(
    MobileRequests,
    LocalisationRequests,
    DrivingRequests,
    ArmRequests,
    CameraRequests,
    FaultRequests,
    SensorRequests,
    WorldRequests,
    SnapshotRequests,
    PassingRequests,
):
    """A simulator node that has been found.

    Args:
        address: How it is reached.
        models: Where models to spawn are looked up.
        features: What it said of itself.
    """

    def __init__(self, address: NodeAddress, models: ModelPath, features: wire.SimulatorFeatures) -> None:
        super().__init__(address, models)
        self._features = features
        self._taken: dict[str, str] = {}  # robots that actors live as, with the types of these
        self.set_clock(features)

    @property
    def features(self) -> wire.SimulatorFeatures:
        """What the node said of itself when its world was loaded."""
        return self._features

    @property
    def robots(self) -> Sequence[wire.RobotInfo]:
        """The robots of its world."""
        return self._features.robots

    def serves(self, contract: type) -> bool:
        """Whether the node has all verbs of a contract, as it says."""
        return not lacking(contract, self._features.features)

    def senses_contacts(self, robot: str) -> bool:
        """See `ContactSensing`."""
        return any(each.senses_contacts for each in self._features.robots if each.name == robot)

    def reserve(self, robot: wire.RobotInfo) -> None:
        """Let nobody live in a robot but those who were given it."""
        self._taken[robot.name] = robot.kinds[0]

    def home_of(self, actor: str, types: Sequence[str]) -> str | None:
        """The robot of the same name, else the first free one that can stand for the actor's type.

        An actor of the type that everything is (`osc_actor`) is a robot by its name only.
        """
        free = [robot for robot in self._features.robots if robot.name not in self._taken]
        fitting = [robot for robot in free if types[0] in robot.kinds]
        named = next((robot for robot in fitting if robot.name == actor), None)
        chosen = named or (next(iter(fitting), None) if types[0] != ANYTHING else None)
        if chosen is None:
            return None
        self._taken[chosen.name] = types[0]
        return chosen.name

    async def start_run(self, happened: Happened, lost: Lost) -> None:
        """Remember whom to tell of contacts, and of the end of the node."""
        self._happened, self._lost = happened, lost
        for warning in self._features.warnings:
            happened(WARNING, {"message": warning})
        if self._loss is not None:
            lost(self._loss)

    async def artifacts(self) -> tuple[wire.Artifact, ...]:
        """What the node has to show of the run."""
        shown = (await self.ask(wire.GET_ARTIFACTS, wire.Empty(), GRANT_TIMEOUT)).artifacts
        return (*shown, *self.saved_snapshots())

    async def load_world(self, world: str, seed: int) -> None:
        """Load a world, at time zero; who lives where is open again."""
        self._features = await self.ask(wire.LOAD_WORLD, wire.LoadWorld(world=world, seed=seed), GRANT_TIMEOUT)
        self._taken.clear()
        self.set_clock(self._features)

    async def change_world(self, world: str) -> None:
        """See `Worlds`."""
        request = wire.ChangeWorld(world=_anywhere(world, self._models.locate), robots=self._taken)
        self._features = await self.ask(wire.CHANGE_WORLD, request, GRANT_TIMEOUT)

    async def begin_from(self, snapshot: wire.Snapshot, seed: int) -> None:
        """Begin at a snapshot, with the clock at zero; who lives where is open again."""
        await self._restore(wire.RestoreState(snapshot=snapshot, purpose=wire.Purpose.BEGIN, seed=seed))
        self._taken.clear()
        self.set_clock(self._features)

    async def end_run(self) -> None:
        """Make every robot stand still."""
        for robot in self._features.robots:
            await self.ask(wire.STOP_ROBOT, wire.StopRobot(robot=robot.name))

    async def clear(self) -> None:
        """Leave nothing of the run: no goal, no watch, no fault, no robot that moves, nothing that was spawned.

        That includes what was asked for by requests whose answers nobody has awaited.
        """
        await self.end_run()
        for number in tuple(self._reporters):  # of goals, too, all of which have ended with `end_run`
            await self.cancel_watch(number)
        if self.serves(Faults):
            for robot in self._features.robots:
                await self.clear_faults(robot.name, "")
        await self.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.SPAWNED))


def _anywhere(world: str, locate: Locate) -> str:
    """A world by its name, or by a path that leads to its file from any folder: the node may run in another."""
    path = Path(world)
    return str(resolved(locate(path))) if path.suffix in WORLD_FILES else world

"""A simulator node as a backend: which actors live in it, grants of time, the end of a run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from seoro.bridges import wire
from seoro.bridges.models import ModelPath
from seoro.bridges.sim.arms import ArmRequests
from seoro.bridges.sim.cameras import CameraRequests
from seoro.bridges.sim.driving import DrivingRequests
from seoro.bridges.sim.faults import FaultRequests
from seoro.bridges.sim.localisation import LocalisationRequests
from seoro.bridges.sim.mobile import MobileRequests
from seoro.bridges.sim.recording import RECORDED_GRANT, RecordingRequests
from seoro.bridges.sim.requests import NodeAddress
from seoro.bridges.sim.sensors import SensorRequests
from seoro.bridges.sim.snapshots import SNAPSHOT_TIMEOUT, SnapshotRequests
from seoro.bridges.sim.world import WorldRequests
from seoro.runtime.contracts import GoalStatus, Happened, Lost, Report

ANYTHING = "osc_actor"
GRANT_TIMEOUT = 30.0  # [s]; a node that is this slow is given up


class SimulatorNode(
    MobileRequests,
    LocalisationRequests,
    DrivingRequests,
    ArmRequests,
    CameraRequests,
    RecordingRequests,
    FaultRequests,
    SensorRequests,
    WorldRequests,
    SnapshotRequests,
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
        self._taken: set[str] = set()
        self._happened: Happened = _ignore
        self._time = features.time

    @property
    def features(self) -> wire.SimulatorFeatures:
        """What the node said of itself when its world was loaded."""
        return self._features

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
        self._taken.add(chosen.name)
        return chosen.name

    async def start_run(self, happened: Happened, lost: Lost) -> None:
        """Remember whom to tell of contacts, and of the end of the node."""
        self._happened, self._lost = happened, lost
        if self._lost_reason is not None:
            lost(self._lost_reason)

    async def advance(self, until: float) -> float:
        """Grant time; tells reporters what happened before the answer's time."""
        if self.is_recording:  # which a grant may end before it is used up: the clock grants more
            until = min(until, self._time + RECORDED_GRANT)
        advanced = await self.ask(wire.ADVANCE, wire.Advance(until=until), GRANT_TIMEOUT)
        for contact in advanced.contacts:
            self._happened("contact", {"first": contact.first, "second": contact.second, "time": contact.time})
        for feedback in advanced.feedback:
            self._happened("navigation_feedback", feedback.model_dump())
        for occurrence in advanced.occurrences:
            report = self._reporters.pop(occurrence.id, None)
            if report is not None:
                report(Report(GoalStatus(occurrence.outcome.value), occurrence.message))
        await self.write_film(advanced.film, advanced.film_error)
        self._time = advanced.time
        return advanced.time

    async def artifacts(self) -> tuple[wire.Artifact, ...]:
        """What the node has to show of the run."""
        shown = (await self.ask(wire.GET_ARTIFACTS, wire.Empty(), GRANT_TIMEOUT)).artifacts
        return (*shown, *self.saved_snapshots())

    async def load_world(self, world: str, seed: int) -> None:
        """Load a world, at time zero; who lives where is open again."""
        self._features = await self.ask(wire.LOAD_WORLD, wire.LoadWorld(world=world, seed=seed), GRANT_TIMEOUT)
        self._taken.clear()
        self._time = self._features.time

    async def begin_from(self, snapshot: wire.Snapshot, seed: int) -> None:
        """Begin at a snapshot, with the clock at zero; who lives where is open again."""
        request = wire.RestoreState(snapshot=snapshot, purpose=wire.Purpose.BEGIN, seed=seed)
        self._features = await self.ask(wire.RESTORE_STATE, request, SNAPSHOT_TIMEOUT)
        self._taken.clear()
        self._time = self._features.time

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
        for robot in self._features.robots:
            await self.clear_faults(robot.name, "")
        await self.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=wire.ResetScope.SPAWNED))


def _ignore(name: str, arguments: Mapping[str, object]) -> None:
    """Before a run has started nobody listens."""

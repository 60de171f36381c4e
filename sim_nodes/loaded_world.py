"""The world of a simulator: loading, changing, saving and restoring it."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from threading import Event

from seoro.bridges import wire
from seoro.bridges.models import ModelPath
from seoro.bridges.wire.refusal import RequestRefused, name_list
from sim_nodes import snapshots
from sim_nodes.event_log import EventLog
from sim_nodes.outcomes import feature_unsupported, incorrect_state
from sim_nodes.physics import Engine, Scene
from sim_nodes.simulation import Simulation
from sim_nodes.snapshots import check_world_change, enter_world
from sim_nodes.streams import Streams
from sim_nodes.tracks import Tracks
from sim_nodes.unsupported import WithoutArms, WithoutTerrain
from sim_nodes.worlds.loader import World, WorldError, load_world

OWN_MODELS = ModelPath()
FORGOTTEN = "the simulation was started over"  # reason for the end of goals


class LoadedWorld:
    """An engine with a world.

    Args:
        engine: The engine.
        start: Name or path of the first world, or a snapshot to continue from.
        seed: Seed; None for 0, or for that of the snapshot.
        models: Search path for model URIs.

    Raises:
        RequestRefused: The world cannot be loaded, or the snapshot does not match.

    Attributes:
        streams: Data published while time passes.
        log: Log of events.
        tracks: Samples of poses for the trace of a run.
        source: Name or path of the world as requested; empty for that of a snapshot.
        state: Stopped, paused, playing, or without a world.
    """

    def __init__(
        self, engine: Engine, start: str | wire.Snapshot, seed: int | None = None, models: ModelPath = OWN_MODELS
    ) -> None:
        self._engine = engine
        self.models = models
        self.streams = Streams()
        self.log = EventLog()
        self.tracks = Tracks()
        self._halted = Event()
        self._origin: str | World  # the world to load without a name
        self.source = ""
        self._simulation: Simulation | None = None
        self.state: wire.SimulationState
        if isinstance(start, wire.Snapshot):
            contents = snapshots.check(start, engine)
            self._origin, self.state = contents.world, wire.SimulationState.PAUSED
            self._activate(snapshots.resumed(contents, engine, seed))
        else:
            self._origin, self.source, self.state = start, start, wire.SimulationState.STOPPED
            self._activate(Simulation(engine, _read(start, seed or 0), seed or 0))

    @property
    def simulation(self) -> Simulation:
        """The loaded world.

        Raises:
            RequestRefused: No world is loaded.
        """
        if self._simulation is None:
            raise RequestRefused(wire.WorldResult.NO_WORLD_LOADED, "no world is loaded; load one first")
        return self._simulation

    @property
    def time(self) -> float:
        """Simulation time [s]; zero without a world."""
        return 0.0 if self._simulation is None else self._simulation.time

    def _activate(self, simulation: Simulation) -> None:
        """Make a simulation the present one, with the streams and the log."""
        simulation.connect_outputs(self.streams, self.log, self.tracks, self._halted)
        with self._reporting_dropped_goals():
            self._simulation = simulation
        self.log.record_world(simulation.world)

    @contextmanager
    def _reporting_dropped_goals(self) -> Iterator[None]:
        """Log results for goals that are gone after the block, unless the block does so."""
        before, number = self._goals(), self.log.number
        yield
        reported = {each.occurrence.id for each in self.log.after(number) if each.occurrence is not None}
        for goal in sorted(before - self._goals() - reported):
            self.log.add(
                wire.Occurrence(
                    id=goal, time=self.time, outcome=wire.Outcome.ABORTED, message=FORGOTTEN, interrupted=True
                )
            )

    def _goals(self) -> set[str]:
        robots = {} if self._simulation is None else self._simulation.robots
        return {goal for robot in robots.values() for goal in robot.goals}

    def _check_paused(self, verb: str) -> None:
        if self.state is wire.SimulationState.PLAYING:
            raise incorrect_state(f"{verb} needs a paused simulation; pause it first")
        self.state = wire.SimulationState.PAUSED

    def unload(self) -> None:
        """Unload the world."""
        extent = self.simulation.world.extent
        self._engine.build(Scene((), (), extent))
        with self._reporting_dropped_goals():
            self._simulation, self.state = None, wire.SimulationState.NO_WORLD
        self.log.record_world(None)

    def load(self, world: str, seed: int) -> None:
        """Load a world and stop at time zero; after a refusal, everything is unchanged.

        If the engine finds overlaps in it, the world before is restarted.

        Args:
            world: Name or path; empty for the loaded one.
            seed: Seed of all randomness.
        """
        origin = world or self._origin
        loaded = _read(origin, seed)
        self.tracks.stop()
        self._check_supported(loaded)
        before = self._simulation
        try:
            self._activate(Simulation(self._engine, loaded, seed))
        except RequestRefused:
            if before is not None:
                self.state = wire.SimulationState.STOPPED
                with self._reporting_dropped_goals():
                    before.reset(wire.ResetScope.ALL)
            raise
        self.state = wire.SimulationState.STOPPED
        self._origin, self.source = origin, origin if isinstance(origin, str) else ""

    def change(self, world: str, robots: Mapping[str, str]) -> None:
        """Continue in another world, in its initial state; after a refusal, everything is unchanged.

        If the engine refuses the world and cannot save its state, the present world restarts; the clock continues.

        Args:
            world: Name or path; it does not change the world that `load` loads without a name.
            robots: Kinds of required robots by name.
        """
        present = self.simulation
        loaded = _read(world, present.seed)
        self._check_supported(loaded)
        check_world_change(present, loaded, robots)
        self._check_paused("change_world")
        self._replace(lambda: enter_world(present, loaded))
        self.source = world

    def _replace(self, make: Callable[[], Simulation]) -> None:
        """Replace the simulation in the engine; if that is refused, restore the present one."""
        present, before = self.simulation, self._contents()
        try:
            self._activate(make())
        except RequestRefused:
            if before is None:
                self._activate(enter_world(present, present.world))
            else:
                self._activate(snapshots.restored(before, present, wire.Purpose.CONTINUE, None))
            raise

    def _check_supported(self, world: World) -> None:
        with_arms = [robot.name for robot in world.robots if robot.declaration.arm is not None]
        if with_arms and isinstance(self._engine, WithoutArms):
            raise feature_unsupported(
                f"the engine {self._engine.name} lacks arms; the world {world.name} has {name_list(with_arms)}"
            )
        if not world.ground.is_flat and isinstance(self._engine, WithoutTerrain):
            raise feature_unsupported(
                f"the engine {self._engine.name} lacks terrain; the world {world.name} has some"
            )

    def save(self) -> wire.Snapshot:
        """Return a snapshot of everything; the simulation is unchanged."""
        return snapshots.take(self.simulation)

    def restore(self, snapshot: wire.Snapshot, purpose: wire.Purpose, seed: int | None) -> None:
        """Restore a snapshot, of this simulator or another; after a refusal, everything is unchanged.

        Args:
            snapshot: The snapshot.
            purpose: Effect on the clock, goals and watches.
            seed: Seed of later random numbers; None for that of the snapshot.
        """
        present = self.simulation
        contents = snapshots.check(snapshot, self._engine)
        self._check_paused("restore_state")
        if purpose is wire.Purpose.BEGIN:
            self.tracks.stop()
        self._replace(lambda: snapshots.restored(contents, present, purpose, seed))
        self.source = ""

    def _contents(self) -> snapshots.Contents | None:
        """Return the contents of a snapshot of the present; None if the physics has diverged."""
        try:
            return snapshots.check(self.save(), self._engine)
        except RequestRefused:
            return None


def _read(world: str | World, seed: int) -> World:
    if isinstance(world, World):
        return world
    try:
        return load_world(world, seed)
    except WorldError as error:
        code = wire.WorldResult.NO_RESOURCE if error.missing else wire.WorldResult.RESOURCE_PARSE_ERROR
        raise RequestRefused(code, str(error)) from error

"""A simulator: an engine, its loaded world, and whether time passes.

States are those of `simulation_interfaces`. Stopped means paused at the initial state. When stopped or paused,
time passes by grants (`advance`) and steps only, which is deterministic. When playing, time follows the wall clock
between requests. Grants and steps are refused then, and events are pending until the first grant after pausing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from threading import Event

from seoro import __version__
from seoro.bridges import wire
from seoro.bridges.models import ModelPath
from seoro.bridges.wire.refusal import RequestRefused, name_list
from sim_nodes import snapshots
from sim_nodes.event_log import EventLog
from sim_nodes.models import FORMATS
from sim_nodes.outcomes import feature_unsupported, incorrect_state, operation_failed
from sim_nodes.pace import SLOWEST, Pace
from sim_nodes.physics import DrivesBodies, Engine, Rewinds, SavesState, Scene
from sim_nodes.simulation import Simulation
from sim_nodes.snapshots import Lookahead, check_world_change, enter_world, return_to, simulate_ahead
from sim_nodes.streams import Streams
from sim_nodes.tracks import Tracks
from sim_nodes.unsupported import WithoutArms, WithoutTerrain
from sim_nodes.worlds.loader import World, WorldError, available_worlds, load_world

REQUIRED_CAPABILITIES: Mapping[str, type] = {
    wire.SAVE_STATE.name: SavesState,
    wire.RESTORE_STATE.name: SavesState,
    wire.REWIND.name: Rewinds,
    wire.SPAWN_PERSON.name: DrivesBodies,
    wire.WALK_ALONG.name: DrivesBodies,
    wire.WANDER.name: DrivesBodies,
    wire.WALK_AFTER.name: DrivesBodies,
    wire.STAND_STILL.name: DrivesBodies,
    wire.MOVE_DOOR.name: DrivesBodies,
    wire.LOCK_DOOR.name: DrivesBodies,
    wire.WATCH_DOOR.name: DrivesBodies,
    wire.MOVE_LIFT.name: DrivesBodies,
    wire.WATCH_LIFT.name: DrivesBodies,
}
"""Optional parts of an engine that verbs require."""
OWN_MODELS = ModelPath()
FORGOTTEN = "the simulation was started over"  # reason for the end of goals
MAX_STEPS = 1_000_000  # of one request


class Simulator:
    """A simulator with a world.

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
        self._pace = Pace(1.0)
        self._ahead: Lookahead | None = None
        self.streams = Streams()
        self.log = EventLog()
        self.tracks = Tracks()
        self._halted = Event()
        self._origin: str | World  # the world to load without a name
        self.source = ""
        self._simulation: Simulation | None = None
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

    def features(self) -> wire.SimulatorFeatures:
        """Return the features of the simulator."""
        return wire.SimulatorFeatures(
            engine=self._engine.name,
            engine_version=self._engine.version,
            version=__version__,
            features=tuple(
                verb.name
                for verb in wire.VERBS
                if isinstance(self._engine, REQUIRED_CAPABILITIES.get(verb.name, object))
            ),
            spawn_formats=FORMATS,
            world="" if self._simulation is None else self._simulation.world.name,
            available_worlds=available_worlds(),
            robots=tuple(self._robots()),
            time=self.time,
            step=1.0 / self._engine.steps_per_second,
            state=self.state,
            world_number=self.log.worlds,
            warnings=() if self._simulation is None else self._simulation.world.warnings,
        )

    @property
    def time(self) -> float:
        """Simulation time [s]; zero without a world."""
        return 0.0 if self._simulation is None else self._simulation.time

    def _robots(self) -> Iterator[wire.RobotInfo]:
        simulation = self._simulation
        if simulation is None:
            return
        for robot in simulation.robots.values():
            yield wire.RobotInfo(
                name=robot.name,
                kinds=robot.declaration.kinds,
                frames=simulation.frames.of(robot),
                devices=robot.faults.devices,
                senses_contacts=True,
            )

    # ------------------------------------------------------------ time

    def halt(self) -> None:
        """End the present grant; from any thread."""
        self._halted.set()

    def resume(self) -> None:
        """Accept grants again."""
        self._halted.clear()

    def advance(self, until: float, horizon: float | None) -> wire.Advanced:
        """Execute a grant of time.

        Args:
            until: End of the grant [s].
            horizon: Time up to which the simulation may go ahead without events [s].
        """
        end = until if horizon is None else horizon
        if not math.isfinite(until) or not math.isfinite(end):
            raise operation_failed(f"invalid grant to {until} with horizon {end}; expected finite times")
        simulation = self.simulation
        self._check_paused("advance")
        simulation.advance(until)
        if horizon is not None and simulation.time >= until and not simulation.pending:
            self._ahead = simulate_ahead(simulation, horizon)
        events = simulation.collect()
        film, film_error = simulation.recording.drain()
        samples, dropped = self.tracks.take()
        return wire.Advanced(
            time=simulation.time,
            occurrences=tuple(each for each in events if isinstance(each, wire.Occurrence)),
            contacts=tuple(each for each in events if isinstance(each, wire.Contact)),
            film=film,
            film_error=film_error,
            feedback=tuple(each for each in events if isinstance(each, wire.NavigationFeedback)),
            departures=tuple(each for each in events if isinstance(each, wire.Departure)),
            tracks=samples,
            dropped_samples=dropped,
        )

    def start_tracks(self, rate: float, scans: float) -> None:
        """Sample poses and scans for the answers to grants, at rates [1/s] from now on; 0 ends it."""
        simulation = self.simulation
        self.tracks.start(rate, scans, simulation.world, simulation.robots, simulation.entities)
        simulation.sample_tracks()

    def rewind(self, time: float) -> float:
        """Return to a time [s] that was passed ahead of the last grant; returns the time after that."""
        ahead, self._ahead = self._ahead, None
        if ahead is not None and ahead.time <= time < self.simulation.time:
            return_to(self.simulation, ahead, time)
            self.tracks.discard()  # the answer that went ahead had them
        return self.time

    def discard_checkpoint(self) -> None:
        """Keep the state after simulating ahead, before another request."""
        self._ahead = None

    def step(self, steps: int) -> float:
        """Make physics steps, regardless of events; returns the time [s]."""
        if not 1 <= steps <= MAX_STEPS:
            raise operation_failed(f"invalid number of steps: {steps}; expected 1 to {MAX_STEPS}")
        simulation = self.simulation
        self._check_paused("step_simulation")
        simulation.step(steps)
        self._drop_pending()
        return simulation.time

    def _drop_pending(self) -> None:
        """Drop pending events from the time without grants, if a client follows the log."""
        if self.log.is_followed:
            self.simulation.collect()

    def _check_paused(self, verb: str) -> None:
        if self.state is wire.SimulationState.PLAYING:
            raise incorrect_state(f"{verb} needs a paused simulation; pause it first")
        self.state = wire.SimulationState.PAUSED

    def set_state(self, state: wire.SimulationState, rate: float = 1.0) -> None:
        """Change the state; stopping resets everything.

        Args:
            state: The state.
            rate: Simulated seconds per second of wall time; infinite for as fast as possible.
        """
        if not rate >= SLOWEST:
            raise operation_failed(f"invalid rate {rate}; expected {SLOWEST:g} or more, or infinite")
        if state is wire.SimulationState.NO_WORLD:
            raise RequestRefused(wire.StateResult.INCORRECT_TRANSITION, "invalid state; unload the world instead")
        world = self.simulation
        if state is self.state:
            raise RequestRefused(wire.StateResult.ALREADY_IN_TARGET_STATE, f"the simulation is already {state}")
        if state is wire.SimulationState.STOPPED:
            with self._reporting_dropped_goals():
                world.reset(wire.ResetScope.ALL)
        self.state = state
        self._pace = Pace(rate)

    def reset(self, scope: int) -> None:
        """Reset the parts that a scope covers."""
        known = wire.ResetScope.TIME | wire.ResetScope.STATE | wire.ResetScope.SPAWNED
        if (scope not in (wire.ResetScope.DEFAULT, wire.ResetScope.ALL) and scope & ~known) or scope < 0:
            raise operation_failed(
                f"unknown reset scope {scope}; expected 0 or 255 for everything, or a sum of "
                "1 (time), 2 (state) and 4 (spawned)"
            )
        with self._reporting_dropped_goals():
            self.simulation.reset(wire.ResetScope(scope))
        self._pace.start_over()

    def keep_pace(self, clock: float) -> float | None:
        """Simulate as far as is due by a monotonic clock, while playing.

        Args:
            clock: Monotonic clock [s].

        Returns:
            Time until more is due [s]; None when not playing.
        """
        if self.state is not wire.SimulationState.PLAYING:
            return None
        self.simulation.run(self._pace.until(clock, self.simulation.time))
        self._drop_pending()
        self.tracks.discard()
        return self._pace.wait(clock, self.simulation.time)


def _read(world: str | World, seed: int) -> World:
    if isinstance(world, World):
        return world
    try:
        return load_world(world, seed)
    except WorldError as error:
        code = wire.WorldResult.NO_RESOURCE if error.missing else wire.WorldResult.RESOURCE_PARSE_ERROR
        raise RequestRefused(code, str(error)) from error

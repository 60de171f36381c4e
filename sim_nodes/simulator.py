"""A simulator: an engine, the world that is loaded in it, and whether time passes.

States are those of `simulation_interfaces`. Stopped is paused at the initial state. Stopped or paused, time
passes in grants (`advance`) and steps only, which is deterministic. Playing, it follows the machine's clock
between requests; grants and steps are refused then, and what happens is held until the first grant after pausing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from importlib.metadata import PackageNotFoundError, version
from threading import Event

from seoro.bridges.models import ModelPath
from seoro.bridges.wire import (
    RESTORE_STATE,
    REWIND,
    SAVE_STATE,
    VERBS,
    Advanced,
    Occurrence,
    Outcome,
    Purpose,
    ResetScope,
    Result,
    RobotInfo,
    SimulationState,
    SimulatorFeatures,
    Snapshot,
    StateResult,
    WorldResult,
)
from seoro.bridges.wire.refusal import RequestRefused, listed
from sim_nodes import snapshots
from sim_nodes.ahead import Ahead, come_back, go_ahead
from sim_nodes.happenings import Log
from sim_nodes.lacking import WithoutArms
from sim_nodes.models import FORMATS
from sim_nodes.pace import SLOWEST, Pace
from sim_nodes.physics import Engine, Rewinds, SavesState, Scene
from sim_nodes.simulation import Simulation
from sim_nodes.streams import Streams
from sim_nodes.succession import check_successor, succeeded
from sim_nodes.worlds.loader import World, WorldError, available_worlds, load_world

NEEDS: Mapping[str, type] = {
    SAVE_STATE.name: SavesState,
    RESTORE_STATE.name: SavesState,
    REWIND.name: Rewinds,
}
"""What an engine has to offer beyond `Engine`, by verb."""
OWN_MODELS = ModelPath()
FORGOTTEN = "the simulation was started over"  # which goals do not outlast
MAX_STEPS = 1_000_000  # of one request


class Simulator:
    """A simulator with a world in it.

    Args:
        engine: The engine.
        beginning: Name or path of the first world, or a snapshot to go on from, with its world.
        seed: Its seed, or that of all that is drawn from the snapshot on; None for 0, or what the snapshot had.
        models: Where models are looked up that are asked for by their URIs.

    Raises:
        RequestRefused: The world cannot be loaded, or the snapshot does not fit.

    Attributes:
        streams: What is published while time passes.
        log: What has happened.
    """

    def __init__(
        self, engine: Engine, beginning: str | Snapshot, seed: int | None = None, models: ModelPath = OWN_MODELS
    ) -> None:
        self._engine = engine
        self.models = models
        self._pace = Pace(1.0)
        self._ahead: Ahead | None = None
        self.streams = Streams()
        self.log = Log()
        self._halted = Event()
        self._origin: str | World  # of the world that is loaded where none is named
        self._source = ""  # of the one that is loaded
        self._simulation: Simulation | None = None
        if isinstance(beginning, Snapshot):
            contents = snapshots.check(beginning, engine, _version())
            self._origin, self._state = contents.world, SimulationState.PAUSED
            self._go_on(snapshots.resumed(contents, engine, seed))
        else:
            self._origin, self._source, self._state = beginning, beginning, SimulationState.STOPPED
            self._go_on(Simulation(engine, _read(beginning), seed or 0))

    @property
    def simulation(self) -> Simulation:
        """The world that is loaded.

        Raises:
            RequestRefused: There is none.
        """
        if self._simulation is None:
            raise RequestRefused(WorldResult.NO_WORLD_LOADED, "no world is loaded: load one first")
        return self._simulation

    def _go_on(self, simulation: Simulation) -> None:
        """Go on with a simulation, and tell of it by the streams that there are."""
        simulation.tell(self.streams, self.log, self._halted)
        with self._telling_of_the_forgotten():
            self._simulation = simulation
        self.log.note_world(simulation.world)

    @contextmanager
    def _telling_of_the_forgotten(self) -> Iterator[None]:
        """Tell those who follow of goals that there are no more after the block, unless it has done so."""
        before, number = self._goals(), self.log.number
        yield
        told = {each.occurrence.id for each in self.log.after(number) if each.occurrence is not None}
        for goal in sorted(before - self._goals() - told):
            self.log.add(
                Occurrence(id=goal, time=self.time, outcome=Outcome.ABORTED, message=FORGOTTEN, interrupted=True)
            )

    def _goals(self) -> set[str]:
        robots = {} if self._simulation is None else self._simulation.robots
        return {goal for robot in robots.values() for goal in robot.goals}

    def unload(self) -> None:
        """Be without a world, until one is loaded."""
        extent = self.simulation.world.extent
        self._engine.build(Scene((), (), extent))
        with self._telling_of_the_forgotten():
            self._simulation, self._state = None, SimulationState.NO_WORLD
        self.log.note_world(None)

    def load(self, world: str, seed: int) -> None:
        """Load a world and stop at time zero; when it cannot be loaded, everything stays as it is.

        When things in it overlap, which only the engine can tell, the world before is started over.

        Args:
            world: Name or path; empty for the one that is loaded already.
            seed: All randomness follows from it.
        """
        origin = world or self._origin
        loaded = _read(origin)
        self._check_offered(loaded)
        before = self._simulation
        try:
            self._go_on(Simulation(self._engine, loaded, seed))
        except RequestRefused:
            if before is not None:
                self._state = SimulationState.STOPPED
                with self._telling_of_the_forgotten():
                    before.reset(ResetScope.ALL)
            raise
        self._state = SimulationState.STOPPED
        self._origin, self._source = origin, origin if isinstance(origin, str) else ""

    def change(self, world: str, robots: Mapping[str, str]) -> None:
        """Go on in another world, at its initial state; when it is refused, everything stays as it is.

        What only the engine finds wrong costs one that cannot save its state the present one: the world that there
        is starts over then, while the clock goes on.

        Args:
            world: Name or path; what `load` loads where no world is named stays as it is.
            robots: Those that it has to have: by name, the kind of each.
        """
        present, loaded = self.simulation, _read(world)
        self._check_offered(loaded)
        check_successor(present, loaded, robots)
        self._hold_still("change_world")
        self._exchange(lambda: succeeded(present, loaded))
        self._source = world

    def _exchange(self, make: Callable[[], Simulation]) -> None:
        """Put another simulation into the engine, or, when that is refused, what was there."""
        present, before = self.simulation, self._contents()
        try:
            self._go_on(make())
        except RequestRefused:
            if before is None:
                self._go_on(succeeded(present, present.world))
            else:
                self._go_on(snapshots.restored(before, present, Purpose.CONTINUE, None))
            raise

    def _check_offered(self, world: World) -> None:
        with_arms = [robot.name for robot in world.robots if robot.declaration.arm is not None]
        if with_arms and isinstance(self._engine, WithoutArms):
            raise RequestRefused(
                Result.FEATURE_UNSUPPORTED,
                f"the engine {self._engine.name} has no arms, and the world {world.name} has {listed(with_arms)}",
            )

    def save(self) -> Snapshot:
        """A snapshot of everything; the simulation goes on as without it."""
        return snapshots.take(self.simulation, _version())

    def restore(self, snapshot: Snapshot, purpose: Purpose, seed: int | None) -> None:
        """Go on from a snapshot, of this simulator or another; when it is refused, everything stays as it is.

        Args:
            snapshot: The snapshot.
            purpose: What becomes of the clock, goals and watches.
            seed: Of all that is drawn from there on; None for that of the snapshot.
        """
        present = self.simulation
        contents = snapshots.check(snapshot, self._engine, _version())
        self._hold_still("restore_state")
        self._exchange(lambda: snapshots.restored(contents, present, purpose, seed))
        self._source = ""

    def _contents(self) -> snapshots.Contents | None:
        """What a snapshot of now would hold; None when physics are lost, which is a reason to go back."""
        try:
            return snapshots.check(self.save(), self._engine, _version())
        except RequestRefused:
            return None

    @property
    def source(self) -> str:
        """Name or path by which the world was asked for; empty for that of a snapshot."""
        return self._source

    @property
    def state(self) -> SimulationState:
        """Whether time passes."""
        return self._state

    def features(self) -> SimulatorFeatures:
        """What the simulator is and has."""
        return SimulatorFeatures(
            engine=self._engine.name,
            engine_version=self._engine.version,
            version=_version(),
            features=tuple(verb.name for verb in VERBS if self._serves(verb.name)),
            spawn_formats=FORMATS,
            world="" if self._simulation is None else self._simulation.world.name,
            available_worlds=available_worlds(),
            robots=tuple(self._robots()),
            time=self.time,
            step=1.0 / self._engine.steps_per_second,
            state=self._state,
            world_number=self.log.worlds,
            warnings=() if self._simulation is None else self._simulation.world.warnings,
        )

    @property
    def time(self) -> float:
        """The clock [s]; zero without a world."""
        return 0.0 if self._simulation is None else self._simulation.time

    def _robots(self) -> Iterator[RobotInfo]:
        simulation = self._simulation
        if simulation is None:
            return
        for robot in simulation.robots.values():
            yield RobotInfo(
                name=robot.name,
                kinds=robot.declaration.kinds,
                frames=simulation.frames.of(robot),
                devices=robot.faults.devices,
                senses_contacts=True,
            )

    def _serves(self, verb: str) -> bool:
        return isinstance(self._engine, NEEDS.get(verb, object))

    # ------------------------------------------------------------ time

    def halt(self) -> None:
        """End the grant that is being carried out, if there is one; from any thread."""
        self._halted.set()

    def go_on(self) -> None:
        """Carry out grants again."""
        self._halted.clear()

    def advance(self, until: float, horizon: float | None) -> Advanced:
        """Carry out a grant of time.

        Args:
            until: Where it ends [s].
            horizon: Up to where the simulation may go ahead, if nothing happens [s].
        """
        end = until if horizon is None else horizon
        if not math.isfinite(until) or not math.isfinite(end):
            raise RequestRefused(
                Result.OPERATION_FAILED, f"time can be granted up to a finite time, not {until} and {end}"
            )
        simulation = self.simulation
        self._hold_still("advance")
        simulation.advance(until)
        if horizon is not None and simulation.time >= until and not simulation.has_to_tell:
            self._ahead = go_ahead(simulation, horizon)
        happened = simulation.collect()
        film, film_error = simulation.films.take()
        return Advanced(
            time=simulation.time,
            occurrences=happened.occurrences,
            contacts=happened.contacts,
            film=film,
            film_error=film_error,
            feedback=happened.feedback,
            departures=happened.departures,
        )

    def rewind(self, time: float) -> float:
        """Be at a time again [s] that was gone ahead of since the last request; returns the time after that."""
        ahead, self._ahead = self._ahead, None
        if ahead is not None and ahead.time <= time < self.simulation.time:
            come_back(self.simulation, ahead, time)
        return self.time

    def stay(self) -> None:
        """Stay where the simulation has gone ahead to: something else is asked for."""
        self._ahead = None

    def step(self, steps: int) -> float:
        """Make physics steps, whatever happens; returns the time [s]."""
        if not 1 <= steps <= MAX_STEPS:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"{steps} steps were asked for: ask for 1 to {MAX_STEPS}"
            )
        simulation = self.simulation
        self._hold_still("step_simulation")
        simulation.step(steps)
        self._let_go()
        return simulation.time

    def _let_go(self) -> None:
        """Hold nothing for the next grant of what has happened while none was given, if somebody follows it."""
        if self.log.is_followed:
            self.simulation.collect()

    def _hold_still(self, verb: str) -> None:
        if self._state is SimulationState.PLAYING:
            raise RequestRefused(
                Result.INCORRECT_STATE,
                f"{verb} needs a paused simulation, and this one is playing: pause it first",
            )
        self._state = SimulationState.PAUSED

    def set_state(self, state: SimulationState, rate: float = 1.0) -> None:
        """Go to a state; stopping resets everything.

        Args:
            state: The state.
            rate: How fast to play, in simulated seconds per second; infinite for as fast as possible.
        """
        if not rate >= SLOWEST:
            raise RequestRefused(
                Result.OPERATION_FAILED, f"the rate is {rate}: it has to be {SLOWEST:g} or more, or infinite"
            )
        if state is SimulationState.NO_WORLD:
            raise RequestRefused(StateResult.INCORRECT_TRANSITION, "unload the world for that")
        world = self.simulation
        if state is self._state:
            raise RequestRefused(StateResult.ALREADY_IN_TARGET_STATE, f"the simulation is {state} already")
        if state is SimulationState.STOPPED:
            with self._telling_of_the_forgotten():
                world.reset(ResetScope.ALL)
        self._state = state
        self._pace = Pace(rate)

    def reset(self, scope: int) -> None:
        """Reset what a scope covers."""
        known = ResetScope.TIME | ResetScope.STATE | ResetScope.SPAWNED
        if (scope not in (ResetScope.DEFAULT, ResetScope.ALL) and scope & ~known) or scope < 0:
            raise RequestRefused(
                Result.OPERATION_FAILED,
                f"the reset scope {scope} is not known: it is 0 or 255 for everything, or a sum of "
                "1 (time), 2 (state) and 4 (spawned)",
            )
        with self._telling_of_the_forgotten():
            self.simulation.reset(ResetScope(scope))
        self._pace.start_over()

    def keep_pace(self, clock: float) -> float | None:
        """While playing, simulate as far as is due by a monotonic clock.

        Args:
            clock: The machine's monotonic clock [s].

        Returns:
            Seconds until there is more to do; None when not playing.
        """
        if self._state is not SimulationState.PLAYING:
            return None
        self.simulation.run(self._pace.until(clock, self.simulation.time))
        self._let_go()
        return self._pace.wait(clock, self.simulation.time)


def _read(world: str | World) -> World:
    if isinstance(world, World):
        return world
    try:
        return load_world(world)
    except WorldError as error:
        code = WorldResult.NO_RESOURCE if error.missing else WorldResult.RESOURCE_PARSE_ERROR
        raise RequestRefused(code, str(error)) from error


def _version() -> str:
    try:
        return version("seoro")
    except PackageNotFoundError:  # run from a source tree that is not installed
        return "0+unknown"

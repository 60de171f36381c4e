"""A simulator: an engine, its loaded world, and whether time passes.

States are those of `simulation_interfaces`. Stopped means paused at the initial state. When stopped or paused,
time passes by grants (`advance`) and steps only, which is deterministic. When playing, time follows the wall clock
between requests. Grants and steps are refused then, and events are pending until the first grant after pausing.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping

from seoro import __version__
from seoro.bridges import wire
from seoro.bridges.models import ModelPath
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.loaded_world import OWN_MODELS, LoadedWorld
from sim_nodes.models import FORMATS
from sim_nodes.outcomes import operation_failed
from sim_nodes.pace import SLOWEST, Pace
from sim_nodes.physics import DrivesBodies, Engine, Rewinds, SavesState
from sim_nodes.snapshots import Lookahead, return_to, simulate_ahead
from sim_nodes.worlds.loader import available_worlds

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
MAX_STEPS = 1_000_000  # of one request


class Simulator(LoadedWorld):
    """A simulator with a world; see `LoadedWorld` for its arguments and attributes."""

    def __init__(
        self, engine: Engine, start: str | wire.Snapshot, seed: int | None = None, models: ModelPath = OWN_MODELS
    ) -> None:
        self._pace = Pace(1.0)
        self._ahead: Lookahead | None = None
        super().__init__(engine, start, seed, models)

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

    def halt(self) -> None:
        """End the present grant; from any thread."""
        self._halted.set()

    def resume(self) -> None:
        """Accept grants again."""
        self._halted.clear()

    def advance(self, until: float, horizon: float | None, *, collects_feedback: bool = False) -> wire.Advanced:
        """Execute a grant of time.

        Args:
            until: End of the grant [s].
            horizon: Time up to which the simulation may go ahead without events [s].
            collects_feedback: Whether it may go ahead past feedback.
        """
        end = until if horizon is None else horizon
        if not math.isfinite(until) or not math.isfinite(end):
            raise operation_failed(f"invalid grant to {until} with horizon {end}; expected finite times")
        simulation = self.simulation
        self._check_paused("advance")
        simulation.advance(until)
        if horizon is not None and simulation.time >= until:
            self._ahead = simulate_ahead(simulation, horizon, past_feedback=collects_feedback)
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

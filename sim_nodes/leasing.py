"""Leases of the robots of a simulator node, and the emergency stop: their verbs, and checks of other requests.

While time passes by itself, runs lease single robots, as behind a bridge, and robots of clients without a sign of
life are stopped. A run that grants time leases the whole node, because there is one clock. Unleased robots may be
used by all.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable, Iterable
from concurrent.futures import Future, InvalidStateError
from contextlib import suppress
from dataclasses import field
from pathlib import Path
from typing import Any, Final

from seoro.bridges import wire
from seoro.bridges.leasing.emergency_stop import EmergencyStopState, selected_robots
from seoro.bridges.leasing.event_filter import events_for, scoped_id
from seoro.bridges.leasing.leases import CONNECTION_LOST, Hold, Leases, describe_silence, expire
from seoro.bridges.serving.robot import robot_state
from seoro.bridges.wire import EmergencyStop, SimulationState, StopAcknowledgement
from seoro.deferred import dataclass
from sim_nodes.outcomes import incorrect_state
from sim_nodes.robots.robot import Robot
from sim_nodes.simulator import Simulator

# Verbs that advance time by grants. Robots that are not stopped may need them.
TIME_VERBS = (wire.STEP_SIMULATION, wire.ADVANCE, wire.REWIND)
# Verbs that affect all robots, by the world or its clock.
WORLD_VERBS = (
    *TIME_VERBS,
    wire.LOAD_WORLD,
    wire.CHANGE_WORLD,
    wire.UNLOAD_WORLD,
    wire.SET_SIMULATION_STATE,
    wire.RESET_SIMULATION,
    wire.RESTORE_STATE,
)
RELEASED = "an emergency stop, which was released at once"
WITHOUT_MOTION = (wire.INJECT_FAULT, wire.CLEAR_FAULTS)  # start no motion


class Leasing:
    """Leases of the robots of a simulator, and its emergency stop. Methods that are named like verbs handle them.

    Args:
        simulator: The simulator.
        stop_file: File that keeps an emergency stop across restarts; None to keep none.

    Attributes:
        latch: State of the emergency stop.
        leases: The leases.
    """

    def __init__(self, simulator: Simulator, stop_file: Path | None = None) -> None:
        self._simulator = simulator
        self.latch = EmergencyStopState(stop_file)
        self.leases = Leases(lambda: self._robots)
        self.stop_robots(self._robots if self.latch.reason else self.latch.robots)  # a snapshot may have goals

    @property
    def _robots(self) -> dict[str, Robot]:
        has_world = self._simulator.state is not SimulationState.NO_WORLD
        return self._simulator.simulation.robots if has_world else {}

    # ------------------------------------------------------------ permissions

    def authorize(self, sender: str, verb: wire.Verb[Any, Any], request: wire.Message) -> wire.Message:
        """Refuse a request that the client may not send; returns it with the robot filled in if it names none.

        Args:
            sender: Client; empty if unknown.
            verb: Verb of the request.
            request: The request.

        Raises:
            RequestRefused: Another client holds the robot, or it is stopped in an emergency.
        """
        if verb in WORLD_VERBS:
            self.latch.check(*self._stopped_by(sender, verb, request))
            self.leases.check_all(sender)
            return request
        if verb.is_read_only or verb is wire.STOP_ROBOT:
            return request
        robot = getattr(request, "robot", None)
        if verb is wire.CMD_VEL and not robot:
            robot = self._first_driven_by(sender)
            request = request.model_copy(update={"robot": robot})
        if verb in (wire.SET_ENTITY_STATE, wire.DELETE_ENTITY):
            robot = getattr(request, "name", "")
        if robot and robot in self._robots:
            if verb not in WITHOUT_MOTION:
                self.latch.check(robot)
            self.leases.check(sender, robot, has_to_hold=False)
        return request

    def _stopped_by(self, sender: str, verb: wire.Verb[Any, Any], request: wire.Message) -> tuple[str, ...]:
        """Return the stopped robots that forbid a request about all robots.

        Time also passes while a robot is stopped, unless the client holds that robot. A stopped robot is not moved
        elsewhere.
        """
        is_state = isinstance(request, wire.SetSimulationState) and request.state is not SimulationState.STOPPED
        if verb in TIME_VERBS or is_state:
            hold = self.leases.hold_of(sender)
            return () if hold is None else self.leases.robots_of(hold)
        return tuple(self._robots)

    def _first_driven_by(self, sender: str) -> str:
        hold = self.leases.hold_of(sender)
        able = [name for name, robot in self._robots.items() if robot.drives]
        return next((name for name in able if hold is not None and hold.holds(name)), next(iter(able), ""))

    # ------------------------------------------------------------ heartbeats

    def stop_overdue(self) -> None:
        """Stop the robots of holders without a recent heartbeat."""
        for hold in self.leases.overdue():
            self._expire(hold, describe_silence(hold))

    def token_changed(self, token: str, *, is_alive: bool) -> None:
        """Handle the appearance of a holder, or the end of its process."""
        if (hold := self.leases.token_changed(token, is_alive=is_alive)) is not None:
            self._expire(hold, CONNECTION_LOST)

    def _expire(self, hold: Hold, reason: str) -> None:
        self._stop(self.leases.robots_of(hold), expire(hold, reason))

    def _stop(self, robots: Iterable[str], reason: str) -> None:
        for robot in robots:
            self._simulator.simulation.stop_robot(robot, reason)

    # ------------------------------------------------------------ verbs

    def get_robot_features(self, _request: wire.Empty) -> wire.RobotFeatures:
        return self._features_of(tuple(self._robots))

    def _features_of(self, names: tuple[str, ...]) -> wire.RobotFeatures:
        features = self._simulator.features()
        return wire.RobotFeatures(
            version=features.version,
            features=features.features,
            robots=tuple(robot for robot in features.robots if robot.name in names),
            number=self._simulator.log.number,
            holder=self.leases.holder_names(names),
        )

    def take_robots(self, holder: wire.Holder) -> wire.RobotFeatures:
        self.latch.check(*(holder.robots or self._robots))
        if holder.gives_signs and self._simulator.state is not SimulationState.PLAYING:
            raise incorrect_state(
                "time passes here only by the grants of one run: declare it a simulator of the lab, or start it "
                "with `--rate 1`, so that its robots move by themselves"
            )
        for gone in self.leases.acquire(holder, self._simulator.time):
            self._forget(gone)
        hold = self.leases.renew(holder.holder)
        return self._features_of(self.leases.robots_of(hold))

    def hold_robots(self, request: wire.HoldRobots) -> wire.LoggedEvents:
        hold = self.leases.hold_of(request.holder) or self.leases.renew(request.holder)
        self.latch.check(*self.leases.robots_of(hold))
        return events_for(hold, self._simulator.log.since(request.since))

    def release_robots(self, holder: wire.Holder) -> None:
        hold = self.leases.hold_of(holder.holder)
        if hold is not None:
            self._stop(self.leases.robots_of(hold), "the run has ended")
            self._forget(hold)
        self.leases.release(holder.holder, waits=holder.waits)

    def _forget(self, hold: Hold) -> None:
        """Cancel the watches of a client."""
        if self._simulator.state is not SimulationState.NO_WORLD:
            self._simulator.simulation.watches.cancel_by_prefix(scoped_id(hold.holder.holder, ""))

    def get_lab_state(self, _request: wire.Empty) -> wire.LabState:
        received, features = time.time(), self._simulator.features()
        return wire.LabState(
            kind=features.engine,
            version=features.version,
            robots=tuple(self._state_of(robot) for robot in features.robots),
            stopped=self.latch.stopped,
            clock="real" if features.state is SimulationState.PLAYING else "granted",
            holder=self.leases.name_of_sole_holder,
            received=received,
            sent=time.time(),
        )

    def _state_of(self, info: wire.RobotInfo) -> wire.RobotState:
        robot = self._robots[info.name]
        pose = robot.mobile.localised_pose() if robot.drives else None
        health = wire.RobotHealth(
            battery=robot.mobile.charge if robot.drives else None,
            localised=pose is not None if robot.drives else None,
            deviation=robot.mobile.deviation() if robot.drives else None,
            position=None if pose is None else (pose.x, pose.y),
            seen=0.0,
        )
        return robot_state(info, health, self.leases, self.latch)

    def lease_robots(self, request: wire.LeaseRobots) -> None:
        self.leases.lease(request)

    def release_lease(self, request: wire.ReleaseLease) -> None:
        self.leases.end_lease(request)

    def latch_stop(self, request: wire.EmergencyStop) -> tuple[str, ...]:
        """Latch an emergency stop of all or the named robots until its release; from any thread.

        Returns:
            Robots to stop by `stop_robots`.

        Raises:
            RequestRefused: None of the named robots is here.
        """
        robots = selected_robots(request.robots, self._robots)
        self.latch.stop(request.model_copy(update={"robots": robots if request.robots else ()}))
        return robots

    def stop_robots(self, robots: Iterable[str]) -> None:
        """Stop robots in an emergency, then let time pass again."""
        self._simulator.resume()
        here = self._robots
        for robot in robots:
            if robot in here:  # the world may have changed since
                self._stop((robot,), self.latch.reason_of(robot) or RELEASED)

    def release_stop(self, request: wire.ReleaseStop) -> None:
        self.latch.release(request)


BUSY: Final = 0.2  # [s] after which a busy node acknowledges a stop, because its time is held


@dataclass(frozen=True)
class _Stop:
    began: float  # [s] of the monotonic clock
    robots: tuple[str, ...]
    stopped: Future[StopAcknowledgement] = field(default_factory=Future)


class EmergencyStops:
    """Emergency stops of a simulator, passed from their own thread to the main thread.

    First, time is held, which the main thread notices between two batches of physics steps. It then stops all or
    the named robots before any other request. A long request, such as loading a world, passes no time, so a stop
    is acknowledged meanwhile.

    Args:
        simulator: Simulator whose time is held.
        leasing: Leases, which stop robots.
        wake: Wakes the main thread.
    """

    def __init__(self, simulator: Simulator, leasing: Leasing, wake: Callable[[], object]) -> None:
        self._simulator = simulator
        self._leasing = leasing
        self._wake = wake
        self._waiting: queue.SimpleQueue[_Stop] = queue.SimpleQueue()
        self._late: threading.Timer | None = None  # of the oldest stop

    def stop(self, request: EmergencyStop) -> Future[StopAcknowledgement]:
        """Stop all robots, or the named ones; called on the thread of emergency stops.

        Raises:
            RequestRefused: None of the named robots is here.
        """
        began = time.monotonic()
        stop = _Stop(began, self._leasing.latch_stop(request))
        self._simulator.halt()
        self._waiting.put(stop)
        self._wake()
        if self._late is None or not self._late.is_alive():
            self._late = threading.Timer(BUSY, self._acknowledge, (stop,))
            self._late.daemon = True
            self._late.start()
        return stop.stopped

    def apply_pending(self) -> bool:
        """Stop the robots, on the main thread, if there are new stops; returns whether there were any."""
        stops: list[_Stop] = []
        while not self._waiting.empty():
            stops.append(self._waiting.get())
        if not stops:
            return False
        self._leasing.stop_robots({robot for stop in stops for robot in stop.robots})
        for stop in stops:
            self._acknowledge(stop)
        return True

    def _acknowledge(self, stop: _Stop) -> None:
        took = time.monotonic() - stop.began
        with suppress(InvalidStateError):  # already acknowledged
            stop.stopped.set_result(StopAcknowledgement(stopped=stop.robots, took=took))

"""Who has which robots of a simulator node, and the emergency stop: the verbs, and what they keep others from.

Where time passes by itself, runs hold single robots, as behind a bridge, and robots of those that give no sign of
life are stopped. Where a run grants time, it has the whole node, since there is one clock. What nobody has may be
used by anybody.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable
from pathlib import Path
from types import MappingProxyType
from typing import Any

from seoro.bridges import wire
from seoro.bridges.leasing.latch import Latch, named_here
from seoro.bridges.leasing.leases import GONE, Hold, Leases, called, lapse, silence
from seoro.bridges.leasing.share import own_id, share_of
from seoro.bridges.wire import Result, SimulationState
from seoro.bridges.wire.refusal import RequestRefused
from seoro.keys.window import HolderKey
from sim_nodes.robots.robot import Robot
from sim_nodes.simulator import Simulator

READING = "get_"  # begins what changes nothing
# What lets time pass in grants, which robots that nobody has stopped may need.
PASSING = frozenset(verb.name for verb in (wire.STEP_SIMULATION, wire.ADVANCE, wire.REWIND))
# What is about the world and its clock, and so about all robots.
OF_ALL = PASSING | frozenset(
    verb.name
    for verb in (
        wire.LOAD_WORLD,
        wire.CHANGE_WORLD,
        wire.UNLOAD_WORLD,
        wire.SET_SIMULATION_STATE,
        wire.RESET_SIMULATION,
        wire.RESTORE_STATE,
    )
)
RELEASED = "an emergency stop, which was released at once"
HARMLESS = frozenset({wire.STOP_ROBOT.name, wire.GET_NAVIGATION_FEEDBACK.name})
STILL = frozenset({wire.INJECT_FAULT.name, wire.CLEAR_FAULTS.name})  # move nothing by themselves

Carry = Callable[[Any], wire.Message]


class Leasing:
    """Who has what of a simulator.

    Args:
        simulator: The simulator.
        stop_file: Where an emergency stop is kept, so that it outlasts the process; None for nowhere.

    Attributes:
        latch: Whether an emergency stop holds.
    """

    def __init__(self, simulator: Simulator, stop_file: Path | None = None) -> None:
        self._simulator = simulator
        self.latch = Latch(stop_file)
        self._leases = Leases(lambda: self._robots)
        self.stop_robots(self._robots if self.latch.reason else self.latch.robots)  # a snapshot may have goals
        verbs: dict[wire.Verb[Any, Any], Carry] = {
            wire.GET_ROBOT_FEATURES: self._features,
            wire.TAKE_ROBOTS: self._take,
            wire.HOLD_ROBOTS: self._hold,
            wire.RELEASE_ROBOTS: self._release,
            wire.GET_LAB_STATE: self._state,
            wire.LEASE_ROBOTS: self._lease,
            wire.RELEASE_LEASE: self._end_lease,
            wire.RELEASE_STOP: self._release_stop,
        }
        self.verbs = MappingProxyType({verb.name: (verb, carry) for verb, carry in verbs.items()})

    @property
    def _robots(self) -> dict[str, Robot]:
        has_world = self._simulator.state is not SimulationState.NO_WORLD
        return self._simulator.simulation.robots if has_world else {}

    # ------------------------------------------------------------ what is asked of the simulator

    def key_of(self, sender: str) -> HolderKey | None:
        """Key of a client that holds robots, or did and has not been replaced, or waits for some."""
        return self._leases.key_of(sender)

    def permit(self, sender: str, verb: str, request: wire.Message) -> wire.Message:
        """Refuse what a client may not ask for; gives the request, with its robot if it does not say which.

        Args:
            sender: Who asks; empty if it does not say.
            verb: Name of the verb.
            request: The request.

        Raises:
            RequestRefused: Another has what it is about, or an emergency stop holds.
        """
        if verb in OF_ALL:
            self.latch.check(*self._stopped_by(sender, verb, request))
            self._leases.check_all(sender)
            return request
        if verb.startswith(READING) or verb in HARMLESS:
            return request
        robot = getattr(request, "robot", None)
        if verb == wire.CMD_VEL.name and not robot:
            robot = self._first_driven_by(sender)
            request = request.model_copy(update={"robot": robot})
        if verb in (wire.SET_ENTITY_STATE.name, wire.DELETE_ENTITY.name):
            robot = getattr(request, "name", "")
        if robot and robot in self._robots:
            if verb not in STILL:
                self.latch.check(robot)
            self._leases.check(sender, robot, has_to_hold=False)
        return request

    def _stopped_by(self, sender: str, verb: str, request: wire.Message) -> tuple[str, ...]:
        """The robots whose stops keep a client from what is about all.

        Time passes also while a robot is stopped, unless the client holds it. Nothing puts that robot elsewhere.
        """
        is_state = isinstance(request, wire.SetSimulationState) and request.state is not SimulationState.STOPPED
        if verb in PASSING or is_state:
            hold = self._leases.hold_of(sender)
            return () if hold is None else self._leases.robots_of(hold)
        return tuple(self._robots)

    def _first_driven_by(self, sender: str) -> str:
        hold = self._leases.hold_of(sender)
        able = [name for name, robot in self._robots.items() if robot.drives]
        return next((name for name in able if hold is not None and hold.has(name)), next(iter(able), ""))

    # ------------------------------------------------------------ signs of life

    def within(self) -> float | None:
        """How long there is nothing to do here [s]; None if nobody has to give signs of life."""
        return self._leases.within()

    def note_life(self, holder: str) -> None:
        """Note a sign of life when it arrives, which may be a while before it is answered.

        Raises:
            RequestRefused: The client does not hold anything.
        """
        self._leases.renew(holder)

    def stop_overdue(self) -> None:
        """Stop robots whose holders should have given a sign of life."""
        for hold in self._leases.overdue():
            self._lapse(hold, silence(hold))

    def lose_sight(self) -> None:
        """The connection to all tokens was lost, on this side, and is there again."""
        self._leases.lose_sight()

    def token_changed(self, token: str, *, is_alive: bool) -> None:
        """A holder has appeared, or its process has died."""
        if (hold := self._leases.token_changed(token, is_alive=is_alive)) is not None:
            self._lapse(hold, GONE)

    def _lapse(self, hold: Hold, why: str) -> None:
        self._stop(self._leases.robots_of(hold), lapse(hold, why))

    def _stop(self, robots: Iterable[str], reason: str) -> None:
        for robot in robots:
            self._simulator.simulation.stop_robot(robot, reason)

    # ------------------------------------------------------------ verbs

    def _features(self, _request: wire.Empty) -> wire.RobotFeatures:
        return self._features_of(tuple(self._robots))

    def _features_of(self, names: tuple[str, ...]) -> wire.RobotFeatures:
        features = self._simulator.features()
        holders = {called(hold.holder): None for name in names if (hold := self._leases.holder_of(name))}
        return wire.RobotFeatures(
            version=features.version,
            features=features.features,
            robots=tuple(robot for robot in features.robots if robot.name in names),
            number=self._simulator.log.number,
            holder=" and ".join(holders),
        )

    def _take(self, holder: wire.Holder) -> wire.RobotFeatures:
        self.latch.check(*(holder.robots or self._robots))
        if holder.gives_signs and self._simulator.state is not SimulationState.PLAYING:
            raise RequestRefused(
                Result.INCORRECT_STATE,
                "time passes here only while one run grants it: name it as a simulator of the lab, or start it "
                "with `--rate 1`, so that its robots move by themselves",
            )
        for gone in self._leases.take(holder, self._simulator.time):
            self._forget(gone)
        hold = self._leases.renew(holder.holder)
        return self._features_of(self._leases.robots_of(hold))

    def _hold(self, request: wire.HoldRobots) -> wire.Happenings:
        hold = self._leases.hold_of(request.holder) or self._leases.renew(request.holder)
        self.latch.check(*self._leases.robots_of(hold))
        return share_of(hold, self._simulator.log.since(request.since))

    def _release(self, holder: wire.Holder) -> wire.Empty:
        hold = self._leases.hold_of(holder.holder)
        if hold is not None:
            self._stop(self._leases.robots_of(hold), "the run has ended")
            self._forget(hold)
        self._leases.release(holder.holder, waits=holder.waits)
        return wire.Empty()

    def _forget(self, hold: Hold) -> None:
        """Forget what a client had watched."""
        if self._simulator.state is not SimulationState.NO_WORLD:
            self._simulator.simulation.forget_watches(own_id(hold.holder.holder, ""))

    def _state(self, _request: wire.Empty) -> wire.LabState:
        received, features = time.time(), self._simulator.features()
        everything = self._leases.holder_of_all
        return wire.LabState(
            kind=features.engine,
            version=features.version,
            robots=tuple(self._state_of(robot) for robot in features.robots),
            stopped=self.latch.stopped,
            clock="real" if features.state is SimulationState.PLAYING else "granted",
            holder="" if everything is None else called(everything.holder),
            received=received,
            sent=time.time(),
        )

    def _state_of(self, info: wire.RobotInfo) -> wire.RobotState:
        robot = self._robots[info.name]
        hold = self._leases.holder_of(info.name)
        pose = robot.mobile.localised_pose() if robot.drives else None
        return wire.RobotState(
            name=info.name,
            kinds=info.kinds,
            battery=robot.mobile.charge if robot.drives else None,
            localised=pose is not None if robot.drives else None,
            deviation=robot.mobile.deviation() if robot.drives else None,
            position=None if pose is None else (pose.x, pose.y),
            seen=0.0,
            holder="" if hold is None else called(hold.holder),
            lease=self._leases.lease_of(info.name),
            waiting=self._leases.waiting_for(info.name),
            stopped=self.latch.robots.get(info.name),
        )

    def _lease(self, request: wire.LeaseRobots) -> wire.Empty:
        self._leases.lease(request)
        return wire.Empty()

    def _end_lease(self, request: wire.ReleaseLease) -> wire.Empty:
        self._leases.end_lease(request)
        return wire.Empty()

    def stop_from_now_on(self, asked: wire.EmergencyStop) -> tuple[str, ...]:
        """Let no robots move, or none of the named ones, until that is released; from any thread.

        Returns:
            The robots that have to be stopped, by `stop_robots`.

        Raises:
            RequestRefused: None of the named robots is here.
        """
        robots = named_here(asked.robots, self._robots)
        self.latch.stop(asked.model_copy(update={"robots": robots if asked.robots else ()}))
        return robots

    def stop_robots(self, robots: Iterable[str]) -> None:
        """Stop robots in an emergency, and let time pass again."""
        self._simulator.go_on()
        here = self._robots
        for robot in robots:
            if robot in here:  # the world may be another one since
                self._stop((robot,), self.latch.reason_of(robot) or RELEASED)

    def _release_stop(self, request: wire.ReleaseStop) -> wire.Empty:
        self.latch.release(request)
        return wire.Empty()

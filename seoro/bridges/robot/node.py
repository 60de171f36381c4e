"""Robots behind a bridge as a backend: heartbeats of the run that holds them, and the events in their answers."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from contextlib import suppress

import anyio

from seoro.bridges import wire
from seoro.bridges.robot.tracks import RobotTracks
from seoro.bridges.session import NoAnswer, NoServer, Refused, SessionError
from seoro.bridges.sim.capabilities import reason_unserved
from seoro.bridges.sim.requests import NodeAddress, to_exception
from seoro.bridges.sim.sensing import SensingRequests
from seoro.bridges.wire.holds import HOLD_DEADLINE, HOLD_PATIENCE
from seoro.errors import BackendError, BackendLost, BackendStopped
from seoro.runtime.contracts.backends import WARNING
from seoro.runtime.contracts.tracks import TrackReporter

ANSWER = 1.0  # [s] time limit of the bridge, beyond the requested wait
PATIENCE = HOLD_PATIENCE
RETRY = 0.05  # [s] between attempts during an outage
PROFILES = "the profile of a ROS 2 robot names its topics and actions"
POSE_TIMEOUT = 1.0  # [s]
STOP_TIMEOUT = 5.0  # [s]; longer than that of bridges for their robots


_LOCALISED = wire.GET_LOCALIZATION.name


class RobotNode(SensingRequests):
    """Held robots of a bridge.

    Actors are never assigned to real robots implicitly: the user names the robot of each actor.

    Args:
        address: Address of the bridge.
        holder: Holder of the robots.
        features: Features of the bridge at the acquisition.
    """

    def __init__(self, address: NodeAddress, holder: wire.Holder, features: wire.RobotFeatures) -> None:
        super().__init__(address)
        self._holder = holder
        self._number = features.number  # of the last reported event
        self._broken_since = math.inf
        self._stood_until = -math.inf  # end of the latest outage in which the node stopped its robots
        self._robots = {robot.name: robot for robot in features.robots}
        localised = [robot.name for robot in features.robots if not robot.verbs or _LOCALISED in robot.verbs]
        is_real = wire.ADVANCE.name not in features.features
        self.tracks = RobotTracks(localised, self._ask_localization, are_real=is_real)

    @property
    def robots(self) -> Sequence[wire.RobotInfo]:
        """The held robots."""
        return tuple(self._robots.values())

    def reason_missing(self, contract: type, robot: str) -> str:
        """See `Selective`. Nodes of other versions do not state the verbs of robots, and refuse at the request."""
        info = self._robots.get(robot)
        if info is None or not info.verbs:
            return ""
        reason = reason_unserved(contract, info.verbs, f"'{robot}'")
        return reason and f"{reason}; {PROFILES}"

    def senses_contacts(self, robot: str) -> bool:
        """See `ContactSensing`."""
        return robot in self._robots and self._robots[robot].senses_contacts

    def assign_robot(self, actor: str, types: Sequence[str]) -> str | None:
        """Return None, see above."""
        return None

    async def start_tracks(self, rate: float, report: TrackReporter, scans: float = 0.0) -> None:
        """See `Tracks`. Robots without a localisation are not reported, and scans are not."""
        if scans:
            self._on_event(WARNING, {"message": f"scans of the robots of {self.name} are not recorded"})
        self.tracks.start(rate, report)

    async def _ask_localization(self, robot: str) -> wire.Localization:
        return await self.ask(wire.GET_LOCALIZATION, wire.RobotName(robot=robot), POSE_TIMEOUT)

    async def end_run(self) -> None:
        """Stop every robot, and report the remaining events."""
        self.tracks.stop()
        for robot in self._robots:
            await self.ask(wire.STOP_ROBOT, wire.StopRobot(robot=robot), STOP_TIMEOUT)
        await self.replay_events()

    # ------------------------------------------------------------ heartbeats

    def loss_since(self, moment: float) -> str:
        """See `Connected`. The node repeats events after an outage, but a long outage stops its robots."""
        if self._broken_since < math.inf:
            return f"{self.name} does not answer"
        if self._stood_until > moment:
            return f"{self.name} was unreachable meanwhile, and its robots stood still"
        return ""

    async def send_heartbeats(self) -> None:
        """Send heartbeats and report events, until cancelled or the bridge is lost."""
        answered = time.monotonic()
        while True:
            request = wire.HoldRobots(holder=self._holder.holder, since=self._number, wait=wire.HOLD_WAIT)
            try:
                events = await self._ask_once(request)
            except Refused as refused:
                loss: BackendError = to_exception(refused)
                if not isinstance(loss, BackendStopped):
                    loss = BackendLost(f"{self.name} no longer obeys: {loss}")
                self.report_loss(loss)
                return
            except (NoServer, NoAnswer) as error:
                self._broken_since = min(self._broken_since, time.monotonic())
                if time.monotonic() - self._broken_since > PATIENCE:
                    self.report_loss(BackendLost(f"{self.name} has not answered for {PATIENCE:g} s: {error}"))
                    return
                await anyio.sleep(RETRY)
                continue
            except (SessionError, wire.WireError) as error:
                self.report_loss(BackendLost(f"{self.name} is unreachable: {error}"))
                return
            self._broken_since = math.inf
            before, answered = answered, time.monotonic()
            if answered - before > HOLD_DEADLINE + wire.HOLD_WAIT:
                self._stood_until = answered
            self._report(events)

    async def replay_events(self) -> None:
        """Report the events that the bridge still keeps."""
        with suppress(SessionError, wire.WireError):
            self._report(await self._ask_once(wire.HoldRobots(holder=self._holder.holder, since=self._number)))

    async def _ask_once(self, request: wire.HoldRobots) -> wire.LoggedEvents:
        verb, within = wire.HOLD_ROBOTS, request.wait + ANSWER
        answer = await self._address.query(verb, wire.encode(request), within, self._holder.holder)
        return verb.read_reply(answer)

    def _report(self, logged: wire.LoggedEvents) -> None:
        new = [event for event in logged.events if event.number > self._number]
        self._number = max(logged.number, self._number)
        for event in new:
            for part in (event.contact, event.departure, event.feedback, event.warning, event.occurrence):
                self.report_event(part)

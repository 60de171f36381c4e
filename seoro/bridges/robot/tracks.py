"""Poses of robots behind a bridge, by their localisation or odometry; see `Tracks`."""

from __future__ import annotations

import math
import time
from collections.abc import Awaitable, Callable, Iterable

import anyio

from seoro.bridges import wire
from seoro.bridges.pose_reports import PoseReports
from seoro.errors import BackendError, BackendRefused
from seoro.robotics.geometry import Pose3D, quaternion
from seoro.runtime.contracts.tracks import TrackReporter

Ask = Callable[[str], Awaitable[wire.Localization]]


class RobotTracks:
    """Asks for the poses of robots at a rate, once it is started.

    Args:
        robots: Names of the robots that have a localisation.
        ask: Asks for the localisation of a robot.
        are_real: Whether they are robots of the real world.
    """

    def __init__(self, robots: Iterable[str], ask: Ask, *, are_real: bool) -> None:
        self._robots = list(robots)
        self._ask = ask
        self._are_real = are_real
        self._started = anyio.Event()
        self._reports: PoseReports | None = None
        self._period = math.inf

    def start(self, rate: float, report: TrackReporter) -> None:
        """Report the robots, and their poses from now on, `rate` times per second of the machine's clock."""
        self._reports, self._period = PoseReports(report, are_real=self._are_real), 1.0 / rate
        for name in self._robots:
            self._reports.announce(name)
        self._started.set()

    def stop(self) -> None:
        """Report nothing more."""
        self._reports = None

    async def run(self) -> None:
        """Ask for poses until cancelled."""
        await self._started.wait()
        due = time.monotonic()
        while self._robots:
            for name in tuple(self._robots):
                await self._sample(name)
            now = time.monotonic()
            due = max(due + self._period, now)
            await anyio.sleep(due - now)

    async def _sample(self, name: str) -> None:
        """Report a pose; robots that refuse are not asked again."""
        if self._reports is None:
            return
        try:
            found = await self._ask(name)
        except BackendRefused:
            self._robots.remove(name)
            return
        except BackendError:  # during an outage; heartbeats report a loss
            return
        reports: PoseReports | None = self._reports  # the run may have ended meanwhile
        if reports is None:
            return
        if found.pose is not None:
            reports.add(name, _values(found.pose), "map")
        elif found.unlocalized is not None:
            reports.add(name, _values(found.unlocalized), found.unlocalized_frame)


def _values(pose: Pose3D) -> tuple[float, ...]:
    """Return position and quaternion x, y, z, w."""
    place, turned = pose.position, pose.orientation
    return (place.x, place.y, place.z, *quaternion(turned.roll, turned.pitch, turned.yaw))

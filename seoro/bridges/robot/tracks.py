"""Poses of robots behind a bridge, by their localisation; see `Tracks`."""

from __future__ import annotations

import math
import time
from collections.abc import Awaitable, Callable, Iterable
from dataclasses import dataclass

import anyio

from seoro.bridges import wire
from seoro.errors import BackendError, BackendRefused
from seoro.robotics.geometry import Pose3D, quaternion
from seoro.runtime.contracts.tracks import PoseSample, SceneChange, TrackReporter

DIGITS = 4  # after the decimal point of numbers
LONGEST_GAP = 1.0  # [s] between two samples of a velocity

Ask = Callable[[str], Awaitable[wire.Localization]]


@dataclass(frozen=True)
class Seen:
    """A pose, and when it was asked for [s, machine clock]."""

    time: float
    pose: Pose3D


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
        self._seen: dict[str, Seen] = {}
        self._last: dict[str, tuple[float, ...]] = {}  # reported values
        self._report: TrackReporter | None = None
        self._period = math.inf

    def start(self, rate: float, report: TrackReporter) -> None:
        """Report the robots, and their poses from now on, `rate` times per second of the machine's clock."""
        self._report, self._period = report, 1.0 / rate
        for name in self._robots:
            entity = {"name": name, "kind": "robot", "real": self._are_real, "shapes": []}
            report(SceneChange("entity", {"time": 0.0, "entity": entity}))
        self._started.set()

    def stop(self) -> None:
        """Report nothing more."""
        self._report = None

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
        """Report a pose that has changed; robots that refuse are not asked again."""
        if self._report is None:
            return
        asked = time.monotonic()
        try:
            pose = (await self._ask(name)).pose
        except BackendRefused:
            self._robots.remove(name)
            return
        except BackendError:  # during an outage; heartbeats report a loss
            return
        if pose is None or not _is_finite(pose):
            return
        before, self._seen[name] = self._seen.get(name), Seen(asked, pose)
        values = (*_position(pose), *_velocity(before, self._seen[name]))
        rounded = tuple(round(value, DIGITS) + 0.0 for value in values)  # no negative zero
        if self._last.get(name) != rounded and self._report is not None:
            self._last[name] = rounded
            self._report(PoseSample(None, {name: rounded}))


def _is_finite(pose: Pose3D) -> bool:
    return all(map(math.isfinite, _position(pose)))


def _position(pose: Pose3D) -> tuple[float, ...]:
    """Return position and quaternion x, y, z, w."""
    place, turned = pose.position, pose.orientation
    return (place.x, place.y, place.z, *quaternion(turned.roll, turned.pitch, turned.yaw))


def _velocity(before: Seen | None, now: Seen) -> tuple[float, ...]:
    """Return the linear and angular velocity between two poses; 0 without an earlier one."""
    if before is None or not 0.0 < now.time - before.time <= LONGEST_GAP:
        return (0.0,) * 6
    passed, old, new = now.time - before.time, before.pose, now.pose
    way = (getattr(new.position, axis) - getattr(old.position, axis) for axis in "xyz")
    turn = math.remainder(new.orientation.yaw - old.orientation.yaw, math.tau)
    return (*(each / passed for each in way), 0.0, 0.0, turn / passed)

"""Poses of robots as samples for the trace: changes only, with velocities from their differences."""

from __future__ import annotations

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final, Literal

from seoro.runtime.contracts.tracks import PoseSample, SceneChange, TrackReporter

DIGITS: Final = 4  # after the decimal point of numbers
LONGEST_GAP: Final = 1.0  # [s] between two samples of a velocity

Frame = Literal["map", "odom"]
"""Frame of poses; `odom` begins where the odometry of a robot began, at an unknown place of the map."""


@dataclass(frozen=True)
class _Seen:
    """A pose, when it was seen [s, clock of the reports], and its frame."""

    time: float
    pose: tuple[float, ...]
    frame: Frame


class PoseReports:
    """Reports of the poses of robots.

    Args:
        report: Called with each sample.
        are_real: Whether they are robots of the real world.
    """

    def __init__(self, report: TrackReporter, *, are_real: bool) -> None:
        self._report = report
        self._are_real = are_real
        self._frames: dict[str, Frame] = {}
        self._seen: dict[str, _Seen] = {}
        self._last: dict[str, tuple[float, ...]] = {}  # reported values

    def announce(self, name: str, frame: Frame = "map", at: float | None = None) -> None:
        """Report a robot, and the frame of its poses, unless both are known; see `add` for the time."""
        if self._frames.get(name) == frame:
            return
        self._frames[name] = frame
        entity = {"name": name, "kind": "robot", "real": self._are_real, "shapes": []}
        if frame != "map":
            entity["frame"] = frame
        time_field = {} if at is None else {"time": at}
        self._report(SceneChange("entity", {**time_field, "entity": entity}))

    def add(self, name: str, pose: Sequence[float], frame: Frame, at: float | None = None) -> None:
        """Report a pose, unless it is invalid or as before.

        Args:
            name: Name of the robot.
            pose: Position [m] and quaternion x, y, z, w.
            frame: Its frame.
            at: Its time on the clock of the run [s]; None for now, by the clock of this machine.
        """
        if not all(map(math.isfinite, pose)):
            return
        self.announce(name, frame, at)
        now = _Seen(time.monotonic() if at is None else at, tuple(pose), frame)
        before = self._seen.get(name)
        self._seen[name] = now
        values = (*now.pose, *_velocity(before, now))
        rounded = tuple(round(value, DIGITS) + 0.0 for value in values)  # no negative zero
        if self._last.get(name) != rounded or before is None or before.frame != frame:
            self._last[name] = rounded
            self._report(PoseSample(at, {name: rounded}))


def _velocity(before: _Seen | None, now: _Seen) -> tuple[float, ...]:
    """Return the linear and angular velocity between two poses; 0 without an earlier one in the same frame."""
    if before is None or before.frame != now.frame or not 0.0 < now.time - before.time <= LONGEST_GAP:
        return (0.0,) * 6
    passed = now.time - before.time
    way = (new - old for new, old in zip(now.pose[:3], before.pose[:3], strict=True))
    turn = math.remainder(_yaw(now.pose) - _yaw(before.pose), math.tau)
    return (*(each / passed for each in way), 0.0, 0.0, turn / passed)


def _yaw(pose: tuple[float, ...]) -> float:
    x, y, z, w = pose[3:]
    return math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z))

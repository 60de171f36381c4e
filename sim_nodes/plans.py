"""Plans of robots in the tracks of a run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

import numpy as np

from seoro.bridges import wire
from sim_nodes.navigation.contracts import Path
from sim_nodes.robots.robot import Robot

PERIOD = 1.0  # [s] between two plans of a robot, at least
DIGITS = 3  # after the decimal point of coordinates


class Plans:
    """Plans that were sampled last."""

    def __init__(self) -> None:
        self._points: dict[str, bytes] = {}
        self._times: dict[str, float] = {}  # [s]

    def sample(self, time: float, robots: Mapping[str, Robot]) -> Iterator[wire.TrackPlan]:
        """Yield the plans that have changed.

        Args:
            time: Present time [s].
            robots: Robots by name.
        """
        for name, robot in robots.items():
            if not robot.drives or time - self._times.get(name, -PERIOD) < PERIOD:
                continue
            points = _points_of(robot.mobile.navigator.plan)
            if points != self._points.get(name, b""):
                self._points[name], self._times[name] = points, time
                yield wire.TrackPlan(robot=name, points=points)

    def copy(self) -> Plans:
        """Return a copy."""
        other = Plans()
        other._points, other._times = dict(self._points), dict(self._times)
        return other


def _points_of(plan: Path | None) -> bytes:
    """Return the points of a plan; of long ones every second, third and so on, and the last."""
    if plan is None:
        return b""
    step = -(-len(plan.points) // (wire.MAX_PLAN - 1))
    points = plan.points[::step] if step == 1 else np.vstack([plan.points[:-1:step], plan.points[-1:]])
    return (np.round(points, DIGITS) + 0.0).astype("<f8").tobytes()

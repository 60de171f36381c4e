"""Motions of drives: short ones for a search, and the shortest connection of two poses.

All poses are (x, y, yaw); costs are lengths that time is proportional to [m].
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, wrap
from sim_nodes.navigation.reeds_shepp import arc_motion, shortest_words
from sim_nodes.robots.drive_declaration import DriveDeclaration, DriveKind

LENGTH = 0.2  # [m] of a motion
SAMPLES = 4  # poses of a motion
SPACING = 0.05  # [m] between poses of a connection
TURN_SPACING = 0.1  # [rad]
TURN = np.deg2rad(15.0)  # of a motion in place
CURVES = (0.0, 0.5, 1.0)  # relative to the smallest turning radius


@dataclass(frozen=True)
class Motions:
    """Motions from the origin.

    Attributes:
        samples: Poses along each motion, the last one is its end, shape (motions, samples, 3).
        costs: Costs of the motions, shape (motions,).
        ways: 1 for forwards, -1 for backwards, 0 otherwise, shape (motions,).
    """

    samples: Array
    costs: Array
    ways: Array


class Mobility(ABC):
    """The motions of a drive.

    Attributes:
        reverse_penalty: Cost of a length backwards, relative to that forwards.
        sideways_penalty: The same sideways; infinite without such motions.
        lever: Length whose costs are those of a turn by one radian [m].
        motions: Short motions.
    """

    reverse_penalty: float
    sideways_penalty = np.inf
    lever = 0.0
    motions: Motions

    @abstractmethod
    def costs(self, ends: Array) -> Array:
        """Return the costs of the connections from the origin to poses, shapes (n, 3) and (n,)."""

    @abstractmethod
    def connection(self, end: Array) -> Array:
        """Return the poses of the connection from the origin to a pose, without the origin, shape (k, 3)."""

    def step_costs(self, poses: Array) -> Array:
        """Return the costs between poses that are close to each other, shapes (n, 3) and (n - 1,)."""
        steps, heading = np.diff(poses, axis=0), poses[:-1, 2]
        ahead = np.cos(heading) * steps[:, 0] + np.sin(heading) * steps[:, 1]
        left = np.cos(heading) * steps[:, 1] - np.sin(heading) * steps[:, 0]
        penalty = np.where(ahead < -0.5 * np.abs(left), self.reverse_penalty, 1.0)
        if np.isfinite(self.sideways_penalty):
            penalty = np.where(np.abs(left) > np.abs(ahead), self.sideways_penalty, penalty)
        return np.hypot(ahead, left) * penalty + self.lever * np.abs(wrap(steps[:, 2]))


class CarMobility(Mobility):
    """A car: arcs of a radius or larger, forwards and backwards.

    Args:
        radius: Smallest turning radius [m].
        reverse_penalty: Cost of a length backwards, relative to that forwards.
    """

    def __init__(self, radius: float, reverse_penalty: float) -> None:
        self._radius = radius
        self.reverse_penalty = reverse_penalty
        curvatures = np.array([sign * curve for curve in CURVES for sign in (1.0, -1.0)][1:]) / self._radius
        samples = np.concatenate([_arcs(curvatures, LENGTH), _arcs(curvatures, -LENGTH)])
        ways = np.repeat((1.0, -1.0), len(curvatures))
        self.motions = Motions(samples, LENGTH * np.where(ways > 0.0, 1.0, reverse_penalty), ways)

    def costs(self, ends: Array) -> Array:
        """See `Mobility.costs`."""
        return self._radius * shortest_words(self._scaled(ends), self.reverse_penalty).costs

    def connection(self, end: Array) -> Array:
        """See `Mobility.connection`."""
        words = shortest_words(self._scaled(end[None]), self.reverse_penalty)
        pose, poses = np.zeros(3), []
        for length, curvature in zip(words.lengths[0].tolist(), words.turns[0].tolist(), strict=True):
            if abs(length) > 1e-9:
                along = length * np.arange(1, _count(length * self._radius, SPACING) + 1)
                piece = _moved(pose, along / len(along), np.full(len(along), curvature))
                poses.append(piece)
                pose = piece[-1]
        found = np.vstack(poses) if poses else np.zeros((1, 3))
        found[:, :2] *= self._radius
        found[-1] = end
        return found

    def _scaled(self, ends: Array) -> Array:
        return ends / (self._radius, self._radius, 1.0)


class TurningMobility(Mobility):
    """A base that turns in place; it drives straight between turns.

    Args:
        lever: Length whose costs are those of a turn by one radian [m].
        reverse_penalty: Cost of a length backwards, relative to that forwards.
    """

    def __init__(self, lever: float, reverse_penalty: float) -> None:
        self.lever = lever
        self.reverse_penalty = reverse_penalty
        curves = np.array([0.0, 1.5, -1.5])
        straight = np.zeros(1)
        turns = np.zeros((2, SAMPLES, 3))
        turns[:, :, 2] = np.outer((TURN, -TURN), np.arange(1, SAMPLES + 1) / SAMPLES)
        parts = [_arcs(curves, LENGTH), _arcs(straight, -LENGTH), turns]
        ahead = LENGTH * (1.0 + self.lever * np.abs(curves))
        costs = [ahead, [LENGTH * self.reverse_penalty], [TURN * self.lever] * 2]
        ways = [[1.0] * 3, [-1.0], [0.0] * 2]
        self.motions = Motions(np.concatenate(parts), np.concatenate(costs), np.concatenate(ways))

    def costs(self, ends: Array) -> Array:
        """See `Mobility.costs`."""
        costs: Array = self._choices(ends)[0].min(axis=0)
        return costs

    def _choices(self, ends: Array) -> tuple[Array, Array]:
        """Return the costs of driving forwards and backwards, and the bearings, shapes (2, n)."""
        length = np.hypot(ends[:, 0], ends[:, 1])
        bearing = np.where(length > 1e-6, np.arctan2(ends[:, 1], ends[:, 0]), 0.0)
        bearings = np.array([bearing, wrap(bearing + np.pi)])
        turned = np.abs(bearings) + np.abs(wrap(ends[:, 2] - bearings))
        return self.lever * turned + np.outer((1.0, self.reverse_penalty), length), bearings

    def connection(self, end: Array) -> Array:
        """See `Mobility.connection`."""
        costs, bearings = self._choices(end[None])
        way = int(costs[:, 0].argmin())
        bearing, length = float(bearings[way, 0]), float(np.hypot(end[0], end[1]))
        there, stays = np.array((end[0], end[1], bearing)), np.array((0.0, 0.0, bearing))
        count = _count(length, SPACING)
        drive = stays + np.arange(1, count + 1)[:, None] / count * (there - stays)
        final = bearing + float(wrap(end[2] - bearing))
        found = np.vstack([_turn(np.zeros(3), bearing), drive, _turn(there, final)])
        found[-1] = end
        return found


class SlidingMobility(TurningMobility):
    """An omnidirectional base; it turns while it moves straight.

    Args:
        lever: Length whose costs are those of a turn by one radian [m].
        sideways_penalty: Cost of a length sideways, relative to that forwards.
    """

    def __init__(self, lever: float, sideways_penalty: float) -> None:
        super().__init__(lever, 1.0)
        self.sideways_penalty = sideways_penalty
        others, sides = self.motions, LENGTH * np.array([sideways_penalty] * 4)
        self.motions = Motions(
            np.concatenate([others.samples, _slides(LENGTH)]),
            np.append(others.costs, sides),
            np.append(others.ways, np.zeros(4)),
        )

    def costs(self, ends: Array) -> Array:
        """See `Mobility.costs`."""
        length, bearing = np.hypot(ends[:, 0], ends[:, 1]), np.arctan2(ends[:, 1], ends[:, 0])
        bearings = np.array([bearing, bearing - ends[:, 2]])  # at the start and at the end
        sideways = (np.abs(np.sin(bearings)) > np.abs(np.cos(bearings))).mean(axis=0)
        penalty = 1.0 + (self.sideways_penalty - 1.0) * sideways
        costs: Array = length * penalty + self.lever * np.abs(wrap(ends[:, 2]))
        return costs

    def connection(self, end: Array) -> Array:
        """See `Mobility.connection`."""
        turn = float(wrap(end[2]))
        count = max(_count(float(np.hypot(end[0], end[1])), SPACING), _count(turn, TURN_SPACING))
        found: Array = np.arange(1, count + 1)[:, None] / count * np.array((end[0], end[1], turn))
        found[-1] = end
        return found


def mobility_of(drive: DriveDeclaration, radius: float, reverse_penalty: float) -> Mobility:
    """Return the motions of a drive.

    Args:
        drive: The drive.
        radius: Smallest turning radius of a car [m].
        reverse_penalty: Cost of a length backwards, relative to that forwards.
    """
    if drive.kind is DriveKind.ACKERMANN:
        return CarMobility(radius, reverse_penalty)
    lever = 0.5 * drive.max_speed / drive.max_turn_rate
    if drive.max_lateral_speed:
        return SlidingMobility(lever, max(1.0, drive.max_speed / drive.max_lateral_speed))
    return TurningMobility(lever, reverse_penalty)


def _arcs(curvatures: Array, length: float) -> Array:
    along = length * np.arange(1, SAMPLES + 1) / SAMPLES
    return np.stack(np.broadcast_arrays(*arc_motion(along, curvatures[:, None])), axis=-1)


def _slides(length: float) -> Array:
    """Return motions to both sides, and diagonally ahead."""
    bearings = np.array([np.pi / 2, -np.pi / 2, np.pi / 4, -np.pi / 4])
    along = length * np.arange(1, SAMPLES + 1) / SAMPLES
    x, y = np.outer(np.cos(bearings), along), np.outer(np.sin(bearings), along)
    return np.stack([x, y, np.zeros_like(x)], axis=-1)


def _moved(pose: Array, lengths: Array, curvatures: Array) -> Array:
    dx, dy, turn = arc_motion(lengths, curvatures)
    cos, sin = np.cos(pose[2]), np.sin(pose[2])
    return np.column_stack([pose[0] + cos * dx - sin * dy, pose[1] + sin * dx + cos * dy, pose[2] + turn])


def _count(length: float, spacing: float) -> int:
    return max(1, int(np.ceil(abs(length) / spacing - 1e-9)))


def _turn(pose: Array, yaw: float) -> Array:
    """Return the poses of a turn in place to a heading."""
    count = _count(yaw - pose[2], TURN_SPACING) if abs(yaw - pose[2]) > 1e-9 else 0
    found = np.tile(pose, (count, 1))
    found[:, 2] += np.arange(1, count + 1) / max(count, 1) * (yaw - pose[2])
    return found

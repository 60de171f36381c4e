"""Contract of backends that report how robots and objects move, for the trace."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import Protocol, runtime_checkable

from seoro.lang.frozen import Value


class PoseSample(Value):
    """Poses at a time; the first sample of a backend has all entities, later ones the moved entities.

    Args:
        time: Time of the sample on the backend's clock [s]; None for now, on the clock of the run.
        entities: Position, quaternion (x, y, z, w), linear and angular velocity by entity [m, m/s, rad/s], in
            `map`; 13 numbers each.
        links: Poses of links that moved against the base of their robot, by robot and link: position [m] and
            quaternion (x, y, z, w) in the frame of the robot.
        believed: x, y [m] and yaw [rad] of the localisation by robot, if they changed.
        removed: Entities that were deleted since the sample before.
    """

    time: float | None
    entities: Mapping[str, tuple[float, ...]]
    links: Mapping[str, Mapping[str, tuple[float, ...]]] = field(default_factory=dict)
    believed: Mapping[str, tuple[float, ...]] = field(default_factory=dict)
    removed: tuple[str, ...] = ()


class SceneChange(Value):
    """Another world, or an entity that was spawned.

    Args:
        kind: Kind of the record, `scene` or `entity`.
        fields: Fields of the record, as JSON data: those of `wire.Scene`, or `time` and `entity`.
    """

    kind: str
    fields: Mapping[str, object]


class PlanSample(Value):
    """Plan of a robot that has planned again.

    Args:
        time: Time on the backend's clock [s].
        robot: Name of the robot.
        points: x, y of its points [m], in `map`; empty without a plan.
    """

    time: float
    robot: str
    points: Sequence[tuple[float, float]]


class ScanSample(Value):
    """Scan of a planar lidar.

    Args:
        time: Time on the backend's clock [s].
        robot: Name of the robot.
        sensor: Name of the lidar.
        pose: Position [m] and quaternion (x, y, z, w) of the lidar in the frame of the robot.
        angle_min: Bearing of the first beam [rad].
        angle_increment: Angle between two beams, to the left [rad].
        ranges: Distances [m]; None without a hit.
    """

    time: float
    robot: str
    sensor: str
    pose: tuple[float, ...]
    angle_min: float
    angle_increment: float
    ranges: Sequence[float | None]


Sample = PoseSample | PlanSample | ScanSample | SceneChange
TrackReporter = Callable[[Sample], None]
"""Callback for a sample or a change of the scene; called on the event loop, between instants."""


@runtime_checkable
class Tracks(Protocol):
    """A backend that reports poses."""

    async def start_tracks(self, rate: float, report: TrackReporter, scans: float = 0.0) -> None:
        """Report the present scene at once, then poses and changes of the scene until the end of the run.

        On a simulated clock, each sample is reported before the time of the run reaches it, or in the grant that
        does. Samples do not change the simulation.

        Args:
            rate: Samples per second of the run's clock [1/s]; above 0, at most 50.
            report: Called with each of them.
            scans: Scans of each planar lidar per second [1/s], at most `rate`; 0 for none. Backends without lidars
                ignore it.
        """

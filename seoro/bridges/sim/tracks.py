"""Samples of poses that a node adds to its answers; see `Tracks`."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from struct import Struct

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.bridges.sim.rules import ProtocolViolation
from seoro.bridges.sim.scenes import plain_entity, scene_change
from seoro.runtime.contracts.backends import WARNING
from seoro.runtime.contracts.tracks import PlanSample, PoseSample, ScanSample, SceneChange, TrackReporter, Tracks

_TOLERANCE = 1e-9  # [s]
_POSES = Struct(f"<{wire.POSE_VALUES}d")
_POINT = Struct("<2d")
_LINK = Struct(f"<{wire.LINK_VALUES}d")
_RANGE = Struct("<f")
_RANGE_DIGITS = 3
_BELIEVED = Struct(f"<{wire.BELIEVED_VALUES}d")


class TrackRequests(Requests):
    """The capability `Tracks` of a node.

    A node that simulates ahead sends samples beyond the time of the run. They are kept until the run reaches them,
    and dropped if the node is rewound.
    """

    _report_sample: TrackReporter | None = None
    _samples: tuple[wire.TrackSample, ...] = ()

    def serves(self, contract: type) -> bool:
        """Whether the node serves all verbs of a contract."""
        raise NotImplementedError

    async def start_tracks(self, rate: float, report: TrackReporter, scans: float = 0.0) -> None:
        """See `Tracks`. Nodes that do not serve it report nothing."""
        if not self.serves(Tracks):
            if scans:
                self._on_event(WARNING, {"message": f"{self.name} reports no scans; the trace has none"})
            return
        scene = await self.ask(wire.GET_SCENE, wire.Empty())
        await self.ask(wire.START_TRACKS, wire.StartTracks(rate=rate, scans=scans))
        self._report_sample = report
        report(scene_change(scene))

    def keep_samples(self, advanced: wire.Advanced) -> None:
        """Replace the samples that wait by those of a new answer."""
        self._samples = advanced.tracks
        if advanced.dropped_samples:
            self._on_event(WARNING, {"message": f"{advanced.dropped_samples} samples of poses were too many"})

    def report_samples(self, until: float) -> None:
        """Report the samples up to a time [s].

        Raises:
            ProtocolViolation: A sample is invalid.
        """
        if self._report_sample is None:
            return
        due = [sample for sample in self._samples if sample.time <= until + _TOLERANCE]
        self._samples = self._samples[len(due) :]
        for sample in due:
            if sample.scene is not None:
                self._report_sample(scene_change(sample.scene))
            for entity in sample.added:
                self._report_sample(SceneChange("entity", {"time": sample.time, "entity": plain_entity(entity)}))
            self._report_sample(self._decode(sample))
            for plan in sample.plans:
                self._report_sample(PlanSample(sample.time, plan.robot, self._decode_plan(plan)))

            for scan in sample.scans:
                self._report_sample(self._decode_scan(sample.time, scan))

    def _decode_scan(self, time: float, scan: wire.TrackScan) -> ScanSample:
        count, rest = divmod(len(scan.ranges), _RANGE.size)
        ranges = [distance for (distance,) in _RANGE.iter_unpack(scan.ranges)] if rest == 0 else []
        placed = (*scan.mount, scan.first, scan.step)
        if rest or count > wire.MAX_BEAMS or not all(map(math.isfinite, placed)) or not _are_ranges(ranges):
            found = f"a scan of {scan.robot} with {len(scan.ranges)} bytes"
            expected = f"at most {wire.MAX_BEAMS} ranges of 0 m or more, of a placed lidar"
            raise ProtocolViolation(f"{self.name} violated the protocol: it sent {found}; expected {expected}")
        return ScanSample(
            time,
            scan.robot,
            scan.sensor,
            (*scan.mount, 0.0, 0.0, 0.0, 1.0),
            scan.first,
            scan.step,
            [round(distance, _RANGE_DIGITS) if math.isfinite(distance) else None for distance in ranges],
        )

    def _decode_plan(self, plan: wire.TrackPlan) -> list[tuple[float, float]]:
        is_whole = len(plan.points) % _POINT.size == 0
        points = list(_POINT.iter_unpack(plan.points)) if is_whole else []
        if not is_whole or len(points) > wire.MAX_PLAN or not _are_finite(points):
            found = f"a plan of {plan.robot} with {len(plan.points)} bytes"
            expected = f"at most {wire.MAX_PLAN} points of finite numbers"
            raise ProtocolViolation(f"{self.name} violated the protocol: it sent {found}; expected {expected}")
        return points

    def _decode(self, sample: wire.TrackSample) -> PoseSample:
        try:
            return PoseSample(
                sample.time,
                _rows(_POSES, sample.entities, sample.poses),
                {each.robot: _rows(_LINK, each.links, each.poses) for each in sample.moved_links},
                _rows(_BELIEVED, sample.localised, sample.believed),
                sample.removed,
            )
        except ValueError as error:
            raise ProtocolViolation(f"{self.name} violated the protocol: {error}") from None


def _rows(row: Struct, names: Sequence[str], data: bytes) -> Mapping[str, tuple[float, ...]]:
    """Decode one row of finite numbers per name.

    Raises:
        ValueError: The size or a number is invalid.
    """
    if len(data) != row.size * len(names):
        raise ValueError(f"it sent {len(data)} bytes of poses of {len(names)} entities; expected {row.size} each")
    rows = dict(zip(names, row.iter_unpack(data), strict=True))
    if not _are_finite(rows.values()):
        raise ValueError("it sent poses that are not finite; expected finite numbers")
    return rows


def _are_ranges(distances: Iterable[float]) -> bool:
    return all(distance >= 0.0 for distance in distances)  # also infinity, not NaN


def _are_finite(rows: Iterable[Sequence[float]]) -> bool:
    # A sum is finite unless a number is not, or very large: five times faster than a look at each number.
    return all(math.isfinite(sum(row)) or all(map(math.isfinite, row)) for row in rows)

"""Records of poses in the trace; see `Tracks`."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from seoro.runtime.contracts.backends import Backend
from seoro.runtime.contracts.tracks import PlanSample, Sample, ScanSample, SceneChange, Tracks
from seoro.runtime.kernel.clock import TIME_DIGITS
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.trace.records import Trace


async def start_tracking(
    backends: Sequence[Backend], rate: float, scans: float, scheduler: Scheduler, trace: Trace
) -> None:
    """Let the backends report poses and scans for the trace.

    Args:
        backends: Backends of the run, which has not begun; those without `Tracks` report nothing.
        rate: Samples per second of the run's clock [1/s]; 0 for none.
        scans: Scans of each lidar per second [1/s]; 0 for none.
        scheduler: Scheduler of the run. On exact clocks, samples are recorded with the next instant.
        trace: The trace.
    """

    def record(sample: Sample) -> None:
        if isinstance(sample, SceneChange):
            time = sample.fields.get("time")
            record_soon(sample.kind, time if isinstance(time, float) else None, sample.fields)
            return
        if isinstance(sample, PlanSample):
            record_soon("path", sample.time, {"entity": sample.robot, "points": list(sample.points)})
            return
        if isinstance(sample, ScanSample):
            record_soon("scan", sample.time, scan_fields(sample))
            return
        fields: dict[str, Any] = {"entities": dict(sample.entities)}
        if sample.links:
            fields["links"] = {robot: dict(links) for robot, links in sample.links.items()}
        if sample.believed:
            fields["believed"] = dict(sample.believed)
        if sample.removed:
            fields["removed"] = list(sample.removed)
        record_soon("poses", sample.time, fields)

    def record_soon(kind: str, time: float | None, fields: Mapping[str, Any]) -> None:
        scheduler.act_in_instant(partial(record_now, kind, time, fields), can_wait=True)

    def record_now(kind: str, time: float | None, fields: Mapping[str, Any]) -> None:
        # By the time of the sample, since that of the instant depends on the speed of the machine.
        at = scheduler.now if time is None else round(time, TIME_DIGITS)
        trace.record_at(at, kind, **{**fields, "time": at})

    if not rate or not trace.is_observed:
        return
    for backend in backends:
        if isinstance(backend, Tracks):
            await backend.start_tracks(rate, record, scans)


def scan_fields(sample: ScanSample) -> Mapping[str, Any]:
    """Return the fields of the record of a scan."""
    return {
        "entity": sample.robot,
        "sensor": sample.sensor,
        "pose": list(sample.pose),
        "angle_min": sample.angle_min,
        "angle_increment": sample.angle_increment,
        "ranges": list(sample.ranges),
    }

"""Records of poses in the trace; see `Tracks`."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from typing import Any

from seoro.runtime.contracts.backends import Backend
from seoro.runtime.contracts.tracks import PlanSample, PoseSample, SceneChange, Tracks
from seoro.runtime.kernel.scheduler import Scheduler
from seoro.runtime.trace.records import Trace


async def start_tracking(backends: Sequence[Backend], rate: float, scheduler: Scheduler, trace: Trace) -> None:
    """Let the backends report poses for the trace.

    Args:
        backends: Backends of the run, which has not begun; those without `Tracks` report nothing.
        rate: Samples per second of the run's clock [1/s]; 0 for none.
        scheduler: Scheduler of the run. On exact clocks, samples are recorded with the next instant.
        trace: The trace.
    """

    def record(sample: PoseSample | PlanSample | SceneChange) -> None:
        if isinstance(sample, SceneChange):
            scheduler.act_in_instant(partial(trace.record, sample.kind, **sample.fields), can_wait=True)
            return
        if isinstance(sample, PlanSample):
            plan = {"time": sample.time, "entity": sample.robot, "points": list(sample.points)}
            scheduler.act_in_instant(partial(trace.record, "path", **plan), can_wait=True)
            return
        fields: dict[str, Any] = {"entities": dict(sample.entities)}
        if sample.believed:
            fields["believed"] = dict(sample.believed)
        if sample.removed:
            fields["removed"] = list(sample.removed)
        scheduler.act_in_instant(partial(record_poses, sample.time, fields), can_wait=True)

    def record_poses(time: float | None, fields: dict[str, Any]) -> None:
        trace.record("poses", time=scheduler.now if time is None else time, **fields)

    if not rate or not trace.is_observed:
        return
    for backend in backends:
        if isinstance(backend, Tracks):
            await backend.start_tracks(rate, record)

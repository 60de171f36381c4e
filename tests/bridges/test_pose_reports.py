"""Samples of poses for traces."""

from __future__ import annotations

import math

import pytest

from seoro.bridges.pose_reports import PoseReports
from seoro.runtime.contracts.tracks import PoseSample, Sample, SceneChange

TURNED = (0.0, 0.0, math.sin(0.25), math.cos(0.25))


@pytest.fixture
def found(monkeypatch: pytest.MonkeyPatch) -> list[Sample]:
    times = iter(range(100))
    monkeypatch.setattr("seoro.bridges.pose_reports.time.monotonic", lambda: next(times) / 2)
    return []


def test_frames_are_reported_when_they_change(found: list[Sample]) -> None:
    reports = PoseReports(found.append, are_real=True)
    reports.announce("tb")
    for frame, x in (("odom", 0.0), ("odom", 0.5), ("map", 7.0), ("map", 7.0)):
        reports.add("tb", (x, 0.0, 0.0, *TURNED), frame)  # type: ignore[arg-type]
    entities = [sample.fields["entity"] for sample in found if isinstance(sample, SceneChange)]
    entity = {"name": "tb", "kind": "robot", "real": True, "shapes": []}
    assert entities == [entity, {**entity, "frame": "odom"}, entity]
    samples = [sample.entities["tb"] for sample in found if isinstance(sample, PoseSample)]
    # No velocity from one frame to another; an equal pose is left out.
    assert [(sample[0], sample[7]) for sample in samples] == [(0.0, 0.0), (0.5, 1.0), (7.0, 0.0)]


def test_invalid_poses_are_left_out(found: list[Sample]) -> None:
    PoseReports(found.append, are_real=False).add("tb", (math.nan, 0.0, 0.0, *TURNED), "map")
    assert found == []

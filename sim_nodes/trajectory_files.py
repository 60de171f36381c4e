"""Trajectories as CSV files."""

from __future__ import annotations

import csv
import math
from collections.abc import Callable, Iterable, Iterator
from io import StringIO

from seoro.bridges.wire import Artifact
from sim_nodes.trajectories import JOINT_COLUMNS, POSE_COLUMNS, Trajectories

DIGITS = 6  # after the decimal point: micrometres


def trajectory_files(trajectories: Trajectories, time_of_tick: Callable[[int], float]) -> Iterator[Artifact]:
    """Yield the files of a run; that of joints only if a robot has some.

    Args:
        trajectories: Samples of the run.
        time_of_tick: Returns the time of a tick [s].
    """
    poses: Iterator[tuple[float | str, ...]] = (
        (time_of_tick(tick), name, *values[:-1], int(values[-1]))
        for tick, name, values in trajectories.poses.rows()
    )
    yield Artifact(
        name="trajectories.csv",
        media_type="text/csv",
        description="poses of robots and movable bodies over time",
        data=_csv(("time", "entity", *POSE_COLUMNS), poses),
    )
    if len(trajectories.joints):
        joints: Iterator[tuple[float | str, ...]] = (
            (time_of_tick(tick), *name.split("/", 1), *values) for tick, name, values in trajectories.joints.rows()
        )
        yield Artifact(
            name="joint_trajectories.csv",
            media_type="text/csv",
            description="joints of robots over time",
            data=_csv(("time", "robot", "joint", *JOINT_COLUMNS), joints),
        )


def _csv(header: tuple[str, ...], rows: Iterable[tuple[float | str, ...]]) -> bytes:
    text = StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(header)
    writer.writerows([_cell(each) for each in row] for row in rows)
    return text.getvalue().encode()


def _cell(value: float | str) -> float | str:
    if isinstance(value, str | int):
        return value
    return "" if math.isnan(value) else round(value, DIGITS) + 0.0  # no negative zero

"""Localisation, obstacles and navigation of all bases in a tick."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from sim_nodes.navigation.decisions import decide
from sim_nodes.navigation.obstacles import Observation, update_together
from sim_nodes.outcomes import GoalResult
from sim_nodes.robots.mobile import MobileBase
from sim_nodes.sensors.lidar import read_together


def sense(bases: Sequence[MobileBase], tick: int) -> None:
    """Update the sensors of bases with a tick, those of lidars together."""
    due = {base.name: lidar for base in bases if (lidar := base.lidar_due(tick)) is not None}
    scans = dict(zip(due, read_together(list(due.values()), tick), strict=True)) if due else {}
    for base in bases:
        base.sense(tick, scans.get(base.name))


def navigate(bases: Sequence[MobileBase], tick: int) -> Mapping[str, tuple[GoalResult]]:
    """Process the scans that have arrived, decide on velocities, and command them; requires `sense` before.

    Returns:
        Results of the goals that ended, by robot.
    """
    observations = []
    for base in bases:
        scan = base.receive_scan()
        if scan is None:
            continue
        base.localisation.update(base.odometry.pose, scan, tick)
        pose = base.localised_pose()
        if pose is not None:
            observations.append(Observation(base.obstacles, pose, scan))
    if observations:
        update_together(observations)
    navigating = [base for base in bases if base.is_navigating]
    inputs = [(base, now) for base in navigating if (now := base.control_input(tick)) is not None]
    results = decide([(base.navigator, now) for base, now in inputs]) if inputs else []
    for base in navigating:
        base.follow_navigator()
    ended = zip(inputs, results, strict=True)
    return {base.name: (result,) for (base, _), result in ended if result is not None}

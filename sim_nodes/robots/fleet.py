"""Localisation, obstacles and navigation of all bases in a tick."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from sim_nodes.outcomes import GoalResult
from sim_nodes.robots.mobile import MobileBase


def navigate(bases: Iterable[MobileBase], tick: int) -> Mapping[str, tuple[GoalResult]]:
    """Process the scans that have arrived, decide on velocities, and command them; requires `sense` before.

    Returns:
        Results of the goals that ended, by robot.
    """
    bases = tuple(bases)
    for base in bases:
        scan = base.receive_scan()
        if scan is None:
            continue
        base.localisation.update(base.odometry.pose, scan, tick)
        pose = base.localised_pose()
        if pose is not None:
            base.obstacles.update(pose, scan)
    navigating = [base for base in bases if base.is_navigating]
    ended = {}
    for base in navigating:
        now = base.control_input(tick)
        result = None if now is None else base.navigator.decide(now)
        if result is not None:
            ended[base.name] = (result,)
        base.follow_navigator()
    return ended

"""Action of `osc.nav2` that drives to positions on the Earth."""

from __future__ import annotations

import math
from collections.abc import Sequence

from seoro.actions.nav2_requests import BASE, run_goal
from seoro.actions.ros_robots import full_name
from seoro.errors import ActionFailed
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import Ros2System
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor, Struct


@action("differential_drive_robot.follow_gps_waypoints", anywhere=Ros2System, uses=BASE)
async def follow_gps_waypoints(
    ctx: ActionContext,
    robot: Actor,
    positions: Sequence[Struct],
    loop_count: int,
    namespace_override: str,
    success_on_acceptance: bool,
) -> None:
    """Drive to each position on the Earth in order, and repeat all of them `loop_count` times."""
    if not positions:
        raise ActionFailed("no position given; expected at least one")
    if loop_count < 0:
        raise ActionFailed(f"invalid `loop_count`: expected at least 0, found {loop_count}")
    degrees = [
        tuple(math.degrees(float(position.fields[name])) for name in ("latitude", "longitude"))  # type: ignore[arg-type]
        for position in positions
    ]
    for latitude, longitude in degrees:
        if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
            raise ActionFailed(f"invalid position: latitude {latitude:g} deg, longitude {longitude:g} deg")
    poses = [{"position": {"latitude": latitude, "longitude": longitude}} for latitude, longitude in degrees]
    name = full_name(robot, namespace_override, "follow_gps_waypoints")
    goal = {"gps_poses": poses * (loop_count + 1)}
    await run_goal(ctx, name, "FollowGPSWaypoints", goal, success_on_acceptance=success_on_acceptance)

"""Actions of `osc.ros` on where a robot and its frames are."""

from __future__ import annotations

from functools import partial

from seoro.actions.reports import finish
from seoro.actions.ros_only import refuse_unless
from seoro.runtime.actions import action
from seoro.runtime.capabilities import MobileRobots
from seoro.runtime.context import ActionContext
from seoro.runtime.contracts import Position3D
from seoro.runtime.values import Actor


@action("differential_drive_robot.tf_close_to", home=MobileRobots)
async def tf_close_to(
    ctx: ActionContext,
    robot: Actor,
    threshold: float,
    reference_point: Position3D,
    robot_frame_id: str,
    sim: bool,
    namespace_override: str,
    parent_frame_id: str,
) -> None:
    """Wait until a frame of the robot is within a distance of a point, in the plane of the parent frame."""
    # `sim` chooses between two clocks of ROS; a run has one.
    refuse_unless(namespace_override=(namespace_override, ""))
    robots, name = ctx.home(robot, MobileRobots)
    watch = partial(robots.watch_proximity, name, robot_frame_id, parent_frame_id, reference_point, threshold)
    await finish(ctx, watch, robots.cancel_watch)


@action("differential_drive_robot.odometry_distance_traveled", home=MobileRobots)
async def odometry_distance_traveled(
    ctx: ActionContext, robot: Actor, distance: float, namespace_override: str
) -> None:
    """Wait until the robot's odometry has counted a distance."""
    refuse_unless(namespace_override=(namespace_override, ""))
    robots, name = ctx.home(robot, MobileRobots)
    await finish(ctx, partial(robots.watch_distance, name, distance), robots.cancel_watch)

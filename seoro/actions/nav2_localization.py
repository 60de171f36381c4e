"""Localisation of robots in a ROS 2 system, as by AMCL of Nav2."""

from __future__ import annotations

import math

from seoro.actions.nav2_requests import MAP, call_service
from seoro.actions.reports import meanwhile
from seoro.actions.ros_robots import full_name, pose_message
from seoro.actions.ros_support import as_action_failure, log_missing, next_message, system_of
from seoro.errors import ActionFailed
from seoro.robotics.geometry import Pose3D
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import ObservedSystem, RobotNames, Ros2System, Wanted
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor

LOCALISED = RobotNames().pose
POSE = "geometry_msgs/msg/PoseWithCovarianceStamped"
QOS = "system_default_reliable"
LATCHED = "system_default_transient_local"
RETRY = 1.0  # [s] between initial poses: the first may arrive before the localization is ready
ATTEMPTS = 10
VARIANCES = {0: 0.25, 7: 0.25, 35: 0.0685}  # of x, y [m^2] and yaw [rad^2]: 0.5 m and 15 degrees, as RViz sends
ACTIVE, FINAL = "active", "finalized"


async def set_initial_pose(ctx: ActionContext, robot: Actor, pose: Pose3D, namespace_override: str) -> None:
    """Publish an initial pose until the localization reports a pose that is new.

    Raises:
        ActionFailed: It reports none for 10 s.
    """
    if not all(map(math.isfinite, (pose.position.x, pose.position.y, pose.orientation.yaw))):
        raise ActionFailed("invalid initial pose: expected finite numbers")
    system, topic = system_of(ctx), full_name(robot, namespace_override, LOCALISED)
    covariance = [VARIANCES.get(index, 0.0) for index in range(36)]
    message = {"header": {"frame_id": MAP}, "pose": {"pose": pose_message(pose), "covariance": covariance}}
    initial = full_name(robot, namespace_override, "initialpose")
    with as_action_failure():
        async with (
            system.publishing(initial, POSE, QOS) as publisher,
            system.subscribing(topic, POSE, QOS) as poses,
        ):
            for _ in range(ATTEMPTS):
                await publisher.wait_for_subscription(RETRY)
                publisher.publish(message)
                try:
                    await next_message(ctx, poses, RETRY)
                except TimeoutError:
                    continue
                return
    raise ActionFailed(
        f"no pose of the localization on {topic} within {ATTEMPTS * RETRY:g} s after the initial pose on {initial}"
    )


async def wait_until_localized(ctx: ActionContext, system: ObservedSystem, topic: str) -> None:
    """Wait for a pose of the localization, also an earlier one.

    Args:
        ctx: Context of the action.
        system: System of the robot.
        topic: Topic of the pose.
    """
    with as_action_failure(), log_missing(ctx, lambda: f"a pose on {topic}"):
        async with system.subscribing(topic, POSE, LATCHED) as poses:
            await next_message(ctx, poses)


async def wait_until_active(ctx: ActionContext, node: str) -> None:
    """Wait until a lifecycle node is active.

    Raises:
        ActionFailed: The node has no life cycle, or is finalized.
    """
    system, state = system_of(ctx), "missing"
    with as_action_failure(), log_missing(ctx, lambda: f"{node} being {ACTIVE}; it is {state}"):
        await meanwhile(ctx, system.wait_for([Wanted("service", f"{node}/get_state")]))
        async with system.lifecycle(node) as states:
            while state != ACTIVE:
                state = await meanwhile(ctx, anext(states))
                if state == FINAL:
                    raise ActionFailed(f"{node} is {state}, and never becomes {ACTIVE}")


@action("differential_drive_robot.request_nomotion_update", anywhere=Ros2System)
async def request_nomotion_update(ctx: ActionContext, robot: Actor, namespace_override: str) -> None:
    """Let the localization take in a scan although the robot stands."""
    name = full_name(robot, namespace_override, "request_nomotion_update")
    await call_service(ctx, name, "std_srvs/srv/Empty", {})

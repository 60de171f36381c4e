"""Actions of `osc.ros` that are carried out wherever a robot lives."""

from __future__ import annotations

from functools import partial

from seoro.actions.reports import finish
from seoro.actions.ros_messages import to_twist
from seoro.actions.ros_only import refuse_unless
from seoro.actions.ros_parameters import set_parameter
from seoro.errors import ActionFailed, InvalidUse
from seoro.lang.plan import EnumValue
from seoro.runtime.actions import action
from seoro.runtime.capabilities import DrivenRobots, Faults, MobileRobots
from seoro.runtime.context import ActionContext
from seoro.runtime.contracts import Position3D
from seoro.runtime.values import Actor

TWISTS = frozenset({"Twist", "TwistStamped"})


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
    robots, _ = ctx.home(robot, MobileRobots)
    watch = partial(robots.watch_proximity, robot_frame_id, parent_frame_id, reference_point, threshold)
    await finish(ctx, watch, robots.cancel_watch)


@action("differential_drive_robot.odometry_distance_traveled", home=MobileRobots)
async def odometry_distance_traveled(
    ctx: ActionContext, robot: Actor, distance: float, namespace_override: str
) -> None:
    """Wait until the robot's odometry has counted a distance."""
    refuse_unless(namespace_override=(namespace_override, ""))
    robots, name = ctx.home(robot, MobileRobots)
    await finish(ctx, partial(robots.watch_distance, name, distance), robots.cancel_watch)


@action("topic_publish", anywhere=DrivenRobots)
async def topic_publish(
    ctx: ActionContext, topic_name: str, topic_type: str, value: str, qos_profile: EnumValue
) -> None:
    """Publish one message; without a ROS graph, commands of velocity to robots of the simulator."""
    # `qos_profile` says how messages may get lost on their way, and here none does.
    package, _, kind = topic_type.replace("/", ".").rpartition(".")
    if package.partition(".")[0] != "geometry_msgs" or kind not in TWISTS:
        raise ActionFailed(
            f"a message of type '{topic_type}' can be published on a ROS 2 graph only; robots in a simulator take "
            "'geometry_msgs.msg.Twist' and 'geometry_msgs.msg.TwistStamped' on their topics /cmd_vel"
        )
    try:
        velocity = to_twist(value)
    except InvalidUse as error:
        raise ActionFailed(str(error)) from error
    await ctx.ask(ctx.anywhere(DrivenRobots).command_velocity(topic_name, velocity))


@action("set_node_parameter", anywhere=Faults)
async def set_node_parameter(
    ctx: ActionContext, node_name: str, parameter_name: str, parameter_value: str
) -> None:
    """Set a parameter of a node."""
    await set_parameter(ctx, node_name, parameter_name, parameter_value)

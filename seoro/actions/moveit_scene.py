"""Actions of `osc.moveit2` with the planning scene of MoveIt, and straight motions by it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from seoro.actions.moveit_requests import call_service, move_group, named_state, run_goal
from seoro.actions.ros_robots import full_name, pose_message
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.robotics.geometry import Pose3D
from seoro.robotics.moveit_errors import describe_failure
from seoro.robotics.moveit_goals import joint_constraints
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.robots import MotionOptions
from seoro.runtime.contracts.ros2 import Ros2System
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor

ARM = "arm"  # one motion at a time
ADD, REMOVE = 0, 1  # moveit_msgs/msg/CollisionObject
SHAPES = {"box": (1, 3), "sphere": (2, 1), "cylinder": (3, 2)}  # number in SolidPrimitive, number of dimensions
NAMES = 4 | 8  # attached objects and objects of the world: moveit_msgs/msg/PlanningSceneComponents
WHOLE = 1.0 - 1e-6  # fraction of a path


@action("arm.move_to_named_pose", anywhere=Ros2System, uses=ARM)
async def move_to_named_pose(
    ctx: ActionContext,
    arm: Actor,
    pose_name: str,
    tolerance: float,
    max_velocity_scaling_factor: float,
    namespace_override: str,
) -> None:
    """Move the joints of the arm to a state that the SRDF names."""
    group = str(arm.fields["arm_group"])
    positions = await named_state(ctx, arm, namespace_override, group, pose_name)
    constraints = joint_constraints(positions, tolerance)
    options = MotionOptions(max_velocity_scaling_factor, tolerance, replan=True)
    await move_group(ctx, full_name(arm, namespace_override, "move_action"), group, constraints, options)


@action("arm.move_along_poses", anywhere=Ros2System, uses=ARM)
async def move_along_poses(
    ctx: ActionContext,
    arm: Actor,
    goal_poses: Sequence[Pose3D],
    max_step: float,
    min_fraction: float,
    avoid_collisions: bool,
    max_velocity_scaling_factor: float,
    namespace_override: str,
) -> None:
    """Move the tool in straight lines through poses in the frame of the arm's base."""
    if not goal_poses:
        raise ActionFailed("no pose given; expected at least one")
    request = {
        "header": {"frame_id": str(arm.fields["base_link"])},
        "start_state": {"is_diff": True},
        "group_name": str(arm.fields["arm_group"]),
        "link_name": str(arm.fields["end_effector"]),
        "waypoints": [pose_message(pose) for pose in goal_poses],
        "max_step": max_step,
        "avoid_collisions": avoid_collisions,
        "max_velocity_scaling_factor": max_velocity_scaling_factor,
        "max_acceleration_scaling_factor": max_velocity_scaling_factor,
    }
    path = await call_service(ctx, arm, namespace_override, "compute_cartesian_path", "GetCartesianPath", request)
    if failure := describe_failure(path):
        raise ActionFailed(f"compute_cartesian_path: {failure}")
    fraction = float(path["fraction"])
    if fraction < min(min_fraction, WHOLE):
        raise ActionFailed(
            f"only {fraction:.0%} of the path can be followed; expected at least {min_fraction:.0%}: look at "
            "obstacles, limits of joints and singular poses on the way"
        )
    goal = {"trajectory": path["solution"]}
    await run_goal(ctx, full_name(arm, namespace_override, "execute_trajectory"), "ExecuteTrajectory", goal)


# ---------------------------------------------------------------- objects


@action("arm.add_collision_object", anywhere=Ros2System)
async def add_collision_object(
    ctx: ActionContext,
    arm: Actor,
    object_name: str,
    shape: EnumValue,
    dimensions: Sequence[float],
    pose: Pose3D,
    frame_id: str,
    namespace_override: str,
) -> None:
    """Add an obstacle to the planning scene, or replace it."""
    number, count = SHAPES[shape.member]
    if len(dimensions) != count or min(dimensions) <= 0.0:
        raise ActionFailed(f"invalid `dimensions` of a {shape.member}: expected {count} lengths above 0")
    added = {
        "id": object_name,
        "header": {"frame_id": frame_id or str(arm.fields["base_link"])},
        "pose": pose_message(pose),
        "primitives": [{"type": number, "dimensions": list(dimensions)}],
        "primitive_poses": [{"orientation": {"w": 1.0}}],
        "operation": ADD,
    }
    await _apply(ctx, arm, namespace_override, {"world": {"collision_objects": [added]}})


@action("arm.remove_collision_object", anywhere=Ros2System)
async def remove_collision_object(
    ctx: ActionContext, arm: Actor, object_name: str, namespace_override: str
) -> None:
    """Remove an obstacle from the planning scene."""
    removed = {"id": object_name, "operation": REMOVE}
    await _apply(ctx, arm, namespace_override, {"world": {"collision_objects": [removed]}})


@action("arm.attach_object", anywhere=Ros2System)
async def attach_object(
    ctx: ActionContext,
    arm: Actor,
    object_name: str,
    link_name: str,
    touch_links: Sequence[str],
    namespace_override: str,
) -> None:
    """Attach an object of the planning scene to a link, which carries it from then on."""
    link = link_name or str(arm.fields["end_effector"])
    attached = {
        "link_name": link,
        "object": {"id": object_name, "operation": ADD},
        "touch_links": [link, *(each for each in touch_links if each != link)],
    }
    await _change_attached(ctx, arm, namespace_override, attached)


@action("arm.detach_object", anywhere=Ros2System)
async def detach_object(ctx: ActionContext, arm: Actor, object_name: str, namespace_override: str) -> None:
    """Detach an object, which stays in the planning scene where it is."""
    await _change_attached(ctx, arm, namespace_override, {"object": {"id": object_name, "operation": REMOVE}})


async def _change_attached(ctx: ActionContext, arm: Actor, namespace: str, attached: Mapping[str, Any]) -> None:
    state = {"is_diff": True, "attached_collision_objects": [attached]}
    await _apply(ctx, arm, namespace, {"robot_state": state})


async def _apply(ctx: ActionContext, arm: Actor, namespace: str, change: Mapping[str, Any]) -> None:
    scene = {"is_diff": True, "robot_state": {"is_diff": True}, **change}
    response = await call_service(
        ctx, arm, namespace, "apply_planning_scene", "ApplyPlanningScene", {"scene": scene}
    )
    if not response["success"]:
        raise ActionFailed("MoveIt rejects the change of the planning scene; look at names, frames and its log")


@action("arm.check_collision_object", anywhere=Ros2System)
async def check_collision_object(
    ctx: ActionContext, arm: Actor, object_name: str, attached: bool, namespace_override: str
) -> None:
    """Fail unless the planning scene has an object, attached to the robot or not."""
    request = {"components": {"components": NAMES}}
    scene = (await call_service(ctx, arm, namespace_override, "get_planning_scene", "GetPlanningScene", request))[
        "scene"
    ]
    world = [each["id"] for each in scene["world"]["collision_objects"]]
    carried = [each["object"]["id"] for each in scene["robot_state"]["attached_collision_objects"]]
    if object_name not in (carried if attached else world):
        raise ActionFailed(
            f"no object '{object_name}' {'attached to the robot' if attached else 'in the planning scene'} "
            f"(in the scene: {', '.join(world) or 'none'}; attached: {', '.join(carried) or 'none'})"
        )

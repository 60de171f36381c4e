"""Actions of `osc.nav2` that call services: costmaps, lifecycle managers, maps, and limits of the speed."""

from __future__ import annotations

from seoro.actions.nav2_requests import call_service
from seoro.actions.ros_robots import full_name
from seoro.actions.ros_support import as_action_failure, system_of
from seoro.errors import ActionFailed
from seoro.lang.plan import EnumValue
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.contracts.ros2 import Members, Ros2System
from seoro.runtime.functions.actions import action
from seoro.runtime.values.values import Actor

COSTMAPS = {
    "local": ("local_costmap",),
    "global": ("global_costmap",),
    "both": ("local_costmap", "global_costmap"),
}
LOAD_RESULTS = {  # nav2_msgs/srv/LoadMap
    1: "the map does not exist on the robot",
    2: "the image of the map is invalid",
    3: "the YAML file of the map is invalid",
    255: "the map server failed; look at its log",
}
SPEED_LIMIT = "nav2_msgs/msg/SpeedLimit"
MATCH_WITHIN = 5.0  # [s] until the controller server receives a limit


@action("differential_drive_robot.clear_costmap", anywhere=Ros2System)
async def clear_costmap(ctx: ActionContext, robot: Actor, costmap: EnumValue, namespace_override: str) -> None:
    """Clear costmaps."""
    await _clear(ctx, robot, costmap, namespace_override, "clear_entirely_{}", "ClearEntireCostmap", {})


@action("differential_drive_robot.clear_costmap_around_robot", anywhere=Ros2System)
async def clear_costmap_around_robot(
    ctx: ActionContext, robot: Actor, distance: float, costmap: EnumValue, namespace_override: str
) -> None:
    """Clear costmaps within a distance of the robot."""
    request = {"reset_distance": distance}
    await _clear(ctx, robot, costmap, namespace_override, "clear_around_{}", "ClearCostmapAroundRobot", request)


@action("differential_drive_robot.clear_costmap_except_region", anywhere=Ros2System)
async def clear_costmap_except_region(
    ctx: ActionContext, robot: Actor, distance: float, costmap: EnumValue, namespace_override: str
) -> None:
    """Clear costmaps beyond a distance of the robot."""
    request = {"reset_distance": distance}
    await _clear(ctx, robot, costmap, namespace_override, "clear_except_{}", "ClearCostmapExceptRegion", request)


async def _clear(
    ctx: ActionContext, robot: Actor, costmap: EnumValue, namespace: str, service: str, kind: str, request: Members
) -> None:
    for each in COSTMAPS[costmap.member]:
        name = full_name(robot, namespace, f"{each}/{service.format(each)}")
        await call_service(ctx, name, kind, request)


@action("differential_drive_robot.manage_lifecycle", anywhere=Ros2System)
async def manage_lifecycle(
    ctx: ActionContext, robot: Actor, command: EnumValue, manager: str, namespace_override: str
) -> None:
    """Change the states of all nodes of a lifecycle manager."""
    name = full_name(robot, namespace_override, f"{manager}/manage_nodes")
    await call_service(ctx, name, "ManageLifecycleNodes", {"command": command.number})


@action("differential_drive_robot.check_lifecycle", anywhere=Ros2System)
async def check_lifecycle(ctx: ActionContext, robot: Actor, manager: str, namespace_override: str) -> None:
    """Fail unless all nodes of a lifecycle manager are active."""
    name = full_name(robot, namespace_override, f"{manager}/is_active")
    await call_service(ctx, name, "std_srvs/srv/Trigger", {})


@action("differential_drive_robot.load_map", anywhere=Ros2System)
async def load_map(ctx: ActionContext, robot: Actor, map_url: str, namespace_override: str) -> None:
    """Load a map from a file of the robot into its map server."""
    name = full_name(robot, namespace_override, "map_server/load_map")
    code = (await call_service(ctx, name, "LoadMap", {"map_url": map_url}))["result"]
    if code:
        raise ActionFailed(f"{name}: {LOAD_RESULTS.get(code, 'unknown error')} (result {code}): {map_url}")


@action("differential_drive_robot.save_map", anywhere=Ros2System)
async def save_map(
    ctx: ActionContext,
    robot: Actor,
    map_url: str,
    map_topic: str,
    image_format: str,
    map_mode: str,
    free_thresh: float,
    occupied_thresh: float,
    namespace_override: str,
) -> None:
    """Save the map of a topic to files of the robot by its map saver."""
    request = {
        "map_topic": map_topic,
        "map_url": map_url,
        "image_format": image_format,
        "map_mode": map_mode,
        "free_thresh": free_thresh,
        "occupied_thresh": occupied_thresh,
    }
    name = full_name(robot, namespace_override, "map_saver/save_map")
    if not (await call_service(ctx, name, "SaveMap", request))["result"]:
        raise ActionFailed(f"{name} has not saved the map of {map_topic} as {map_url}; look at its log")


@action("differential_drive_robot.limit_speed", anywhere=Ros2System)
async def limit_speed(ctx: ActionContext, robot: Actor, speed: float, namespace_override: str) -> None:
    """Limit the speed of the controller of Nav2; 0 removes the limit."""
    await _limit(ctx, robot, {"percentage": False, "speed_limit": speed}, namespace_override)


@action("differential_drive_robot.limit_speed_share", anywhere=Ros2System)
async def limit_speed_share(ctx: ActionContext, robot: Actor, share: float, namespace_override: str) -> None:
    """Limit the speed of the controller of Nav2 to a share of its maximum."""
    if not 0.0 < share <= 1.0:
        raise ActionFailed(f"invalid `share`: expected more than 0 and at most 1, found {share:g}")
    await _limit(ctx, robot, {"percentage": True, "speed_limit": 100.0 * share}, namespace_override)


async def _limit(ctx: ActionContext, robot: Actor, message: Members, namespace: str) -> None:
    topic = full_name(robot, namespace, "speed_limit")
    with as_action_failure():
        async with system_of(ctx).publishing(topic, SPEED_LIMIT, "system_default_reliable") as publisher:
            if not await publisher.wait_for_subscription(MATCH_WITHIN):
                raise ActionFailed(f"no subscription to {topic}; look at the state of the controller server")
            publisher.publish(message)

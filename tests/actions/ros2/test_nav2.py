"""Actions of `osc.nav2` in a ROS 2 system, with servers by the published definitions of distributions."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.action_server import Status
from seoro.embed import prepare
from seoro.embed.options import Options
from seoro.errors import UsageError
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import expect_failure, ran_of, running
from tests.actions.ros2.definitions_server import Offer, Servers, serving
from tests.runtime.conftest import Ran, load_text
from tests.tools.ros_definitions import definitions

POSE = "pose_3d(position_3d(x: 1m, y: 2m))"
PATH = {"header": {"frame_id": "map"}, "poses": [{"pose": {"position": {"x": x}}} for x in (0.0, 3.0)]}
LIMIT = 120.0  # [s] of a run of a second


def action(
    name: str, kind: str, answer: Mapping[str, Any] | None = None, status: Status = Status.SUCCEEDED
) -> Offer:
    return Offer(name, f"nav2_msgs/action/{kind}", answer or {}, status)


def service(name: str, kind: str, answer: Mapping[str, Any] | None = None) -> Offer:
    return Offer(name, kind if "/" in kind else f"nav2_msgs/srv/{kind}", answer or {})


async def run(
    folder: Path, router: str, lines: str, *offers: Offer, distribution: str = "jazzy", namespace: str = ""
) -> tuple[Ran, Servers]:
    """Run invocations of a robot on servers."""
    body = "".join(f"        {line.strip()}\n" for line in lines.strip().splitlines())
    text = (
        f"import osc.nav2\nimport osc.localization\nscenario main:\n    robot: differential_drive_robot with:\n"
        f"        keep(it.namespace == '{namespace}')\n    var path: string = ''\n    do serial:\n{body}"
    )
    with anyio.fail_after(LIMIT):
        async with (
            serving(router, definitions(distribution), offers) as servers,
            running(folder, router, text) as started,
        ):
            return await ran_of(started), servers


ACTIONS: list[tuple[str, Offer, Callable[[dict[str, Any]], bool]]] = [
    (
        f"robot.nav_to_pose({POSE})",
        action("/navigate_to_pose", "NavigateToPose"),
        lambda goal: goal["pose"]["pose"]["position"] == {"x": 1.0, "y": 2.0, "z": 0.0},
    ),
    (
        f"robot.follow_waypoints([{POSE}], loop_count: 1)",
        action("/follow_waypoints", "FollowWaypoints"),
        lambda goal: [each["header"]["frame_id"] for each in goal["poses"]] == ["map", "map"],
    ),
    (
        "robot.follow_gps_waypoints([geodetic_position_2d(latitude: 48.5deg, longitude: 9deg)])",
        action("/follow_gps_waypoints", "FollowGPSWaypoints"),
        lambda goal: math.isclose(goal["gps_poses"][0]["position"]["latitude"], 48.5),
    ),
    (
        "robot.spin(-90deg, time_limit: 12.5s)",
        action("/spin", "Spin"),
        lambda goal: (
            math.isclose(goal["target_yaw"], -math.pi / 2, abs_tol=1e-6)
            and goal["time_allowance"] == {"sec": 12, "nanosec": 500_000_000}
        ),
    ),
    (
        "robot.backup(20cm, speed: 0.25mps)",
        action("/backup", "BackUp"),
        lambda goal: (round(goal["target"]["x"], 6), goal["speed"]) == (0.2, 0.25),
    ),
    (
        "robot.drive_on_heading(1m, speed: 0.5mps)",
        action("/drive_on_heading", "DriveOnHeading"),
        lambda goal: (goal["target"]["x"], goal["speed"]) == (1.0, 0.5),
    ),
    ("robot.wait_in_place(3s)", action("/wait", "Wait"), lambda goal: goal["time"]["sec"] == 3),
    (
        "robot.assisted_teleop(9s)",
        action("/assisted_teleop", "AssistedTeleop"),
        lambda goal: goal["time_allowance"]["sec"] == 9,
    ),
    (
        "robot.dock('home', max_staging_time: 60s)",
        action("/dock_robot", "DockRobot"),
        lambda goal: (goal["use_dock_id"], goal["dock_id"], goal["max_staging_time"]) == (True, "home", 60.0),
    ),
    (
        f"robot.dock_at_pose({POSE}, 'simple', navigate_to_staging_pose: false)",
        action("/dock_robot", "DockRobot"),
        lambda goal: (goal["use_dock_id"], goal["dock_type"]) == (False, "simple"),
    ),
    (
        "robot.undock('simple')",
        action("/undock_robot", "UndockRobot"),
        lambda goal: (goal["dock_type"], goal["max_undocking_time"]) == ("simple", 30.0),
    ),
    (
        "robot.track_route(5, start_node: 2)",
        action("/compute_and_track_route", "ComputeAndTrackRoute"),
        lambda goal: (goal["start_id"], goal["goal_id"], goal["use_start"]) == (2, 5, True),
    ),
    (
        "robot.load_map('/maps/hall.yaml')",
        service("/map_server/load_map", "LoadMap"),
        lambda request: request == {"map_url": "/maps/hall.yaml"},
    ),
    (
        "robot.save_map('/maps/new')",
        service("/map_saver/save_map", "SaveMap", {"result": True}),
        lambda request: (request["map_topic"], request["map_mode"]) == ("map", "trinary"),
    ),
    (
        "robot.manage_lifecycle(lifecycle_command!reset)",
        service("/lifecycle_manager_navigation/manage_nodes", "ManageLifecycleNodes", {"success": True}),
        lambda request: request == {"command": 3},
    ),
    (
        "robot.check_lifecycle()",
        service("/lifecycle_manager_navigation/is_active", "std_srvs/srv/Trigger", {"success": True}),
        lambda request: request == {},
    ),
    (
        "robot.clear_costmap_around_robot(2m, nav2_costmap!local)",
        service("/local_costmap/clear_around_local_costmap", "ClearCostmapAroundRobot"),
        lambda request: request == {"reset_distance": 2.0},
    ),
    (
        "robot.clear_costmap_except_region(2m, nav2_costmap!global)",
        service("/global_costmap/clear_except_global_costmap", "ClearCostmapExceptRegion"),
        lambda request: request == {"reset_distance": 2.0},
    ),
    (
        "robot.request_nomotion_update()",
        service("/request_nomotion_update", "std_srvs/srv/Empty"),
        lambda request: request == {},
    ),
    (
        "robot.reinitialize_global_localization()",
        service("/reinitialize_global_localization", "std_srvs/srv/Empty"),
        lambda request: request == {},
    ),
]


async def test_actions_send_the_goals_and_requests_of_nav2(tmp_path: Path, router: str) -> None:
    docks = [each for each in ACTIONS if each[1].name == "/dock_robot"]
    single = [each for each in ACTIONS if each not in docks[1:]]
    ran, servers = await run(
        tmp_path, router, "\n".join(each[0] for each in single), *(each[1] for each in single)
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    for invocation, offer, fits in single:
        assert fits(servers.of(offer.name)), (invocation, servers.of(offer.name))
    ran, servers = await run(tmp_path, router, docks[1][0], docks[1][1])
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert docks[1][2](servers.of("/dock_robot"))


@pytest.mark.parametrize("distribution", ["humble", "jazzy", "kilted", "lyrical"])
async def test_goals_fit_the_definitions_of_distributions(tmp_path: Path, router: str, distribution: str) -> None:
    lines = f"""
        robot.nav_through_poses([{POSE}, {POSE}])
        robot.compute_path_through_poses([{POSE}], path_variable: path)
        robot.follow_computed_path(path)
        robot.spin(90deg)
        robot.clear_costmap(nav2_costmap!global)
        robot.check_path(path)
    """
    done = {"success": True} if distribution == "lyrical" else {}
    ran, servers = await run(
        tmp_path,
        router,
        lines,
        action("/r1/navigate_through_poses", "NavigateThroughPoses"),
        action("/r1/compute_path_through_poses", "ComputePathThroughPoses", {"path": PATH}),
        action("/r1/follow_path", "FollowPath"),
        action("/r1/spin", "Spin"),
        service("/r1/global_costmap/clear_entirely_global_costmap", "ClearEntireCostmap", done),
        service("/r1/is_path_valid", "IsPathValid", {"is_valid": True, **done}),
        distribution=distribution,
        namespace="r1",
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    poses = servers.of("/r1/navigate_through_poses")["poses"]
    assert len(poses if isinstance(poses, list) else poses["goals"]) == 2
    assert [pose["pose"]["position"]["x"] for pose in servers.of("/r1/follow_path")["path"]["poses"]] == [0.0, 3.0]


async def test_paths_are_planned_smoothed_and_measured(tmp_path: Path, router: str) -> None:
    offers = (
        action("/compute_path_to_pose", "ComputePathToPose", {"path": PATH}),
        action("/smooth_path", "SmoothPath", {"path": PATH, "was_completed": True}),
        action(
            "/compute_route", "ComputeRoute", {"route": {"nodes": [{"nodeid": 1}, {"nodeid": 7}]}, "path": PATH}
        ),
        service("/is_path_valid", "IsPathValid", {"is_valid": False, "invalid_pose_indices": [1]}),
    )
    lines = f"""
        robot.compute_path_to_pose({POSE}, planner_id: 'GridBased', path_variable: path)
        robot.smooth_path(path, path_variable: path)
        robot.compute_route(7)
        log(path)
    """
    ran, servers = await run(tmp_path, router, lines, *offers)
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    texts = [text for _, text in ran.logs if not text.startswith("the response")]
    assert texts[0] == "path of 3.00 m with 2 poses"
    assert "route through the nodes 1, 7" in texts
    assert len(json.loads(texts[-1])["poses"]) == 2
    assert servers.of("/compute_path_to_pose")["planner_id"] == "GridBased"
    assert servers.of("/compute_route")["use_start"] is False
    long, _ = await run(tmp_path, router, f"robot.compute_path_to_pose({POSE}, max_length: 2m)", *offers)
    expect_failure(long.verdict, r"the path has a length of 3\.00 m; expected at most 2 m")
    lines = f"robot.compute_path_to_pose({POSE}, path_variable: path)\nrobot.check_path(path)"
    invalid, _ = await run(tmp_path, router, lines, *offers)
    expect_failure(invalid.verdict, "the path is invalid at 1 poses, first at pose 1")


@pytest.mark.parametrize(
    ("invocation", "offer", "reason"),
    [
        (
            f"robot.nav_to_pose({POSE})",
            action(
                "/navigate_to_pose", "NavigateToPose", {"error_code": 206, "error_msg": "at 1, 2"}, Status.ABORTED
            ),
            "the goal of /navigate_to_pose was aborted: the goal is in an obs.*GOAL_OCCUPIED, error 206.*at 1, 2",
        ),
        (
            f"robot.follow_waypoints([{POSE}])",
            action("/follow_waypoints", "FollowWaypoints", {"missed_waypoints": [{"index": 0}]}),
            "/follow_waypoints: missed waypoints: 1",
        ),
        (
            "robot.dock('home')",
            action("/dock_robot", "DockRobot", {"success": False, "error_code": 906}, Status.ABORTED),
            "the robot is docked but does not charge",
        ),
        (
            "robot.load_map('/a.yaml')",
            service("/map_server/load_map", "LoadMap", {"result": 1}),
            "the map does not exist on the robot",
        ),
        (
            "robot.save_map('/a')",
            service("/map_saver/save_map", "SaveMap", {"result": False}),
            "/map_saver/save_map has not saved the map",
        ),
        (
            "robot.check_lifecycle()",
            service("/lifecycle_manager_navigation/is_active", "std_srvs/srv/Trigger", {"success": False}),
            "is_active reports no success",
        ),
        ("robot.backup(-1m)", action("/backup", "BackUp"), "invalid `distance`: expected more than 0, found -1"),
        ("robot.follow_computed_path('{}')", action("/follow_path", "FollowPath"), "the path has no poses"),
        ("robot.spin(1rad, check_collisions: false)", action("/spin", "Spin"), "unknown member"),
        ("robot.limit_speed_share(1.5)", action("/spin", "Spin"), "invalid `share`"),
    ],
)
async def test_failures_have_reasons(
    invocation: str, offer: Offer, reason: str, tmp_path: Path, router: str
) -> None:
    ran, _ = await run(tmp_path, router, invocation, offer)
    expect_failure(ran.verdict, reason)


async def test_actions_without_a_counterpart_in_simulators_need_a_ros_system(tmp_path: Path) -> None:
    text = "import osc.nav2\nscenario main:\n    robot: differential_drive_robot\n    do robot.dock('home')\n"
    with pytest.raises(UsageError, match="cannot carry out") as raised:
        async with prepare(load_text(tmp_path, text, ()), Options(clock="virtual")):
            pass
    assert "--ros" in raised.value.help


POSES = "geometry_msgs/msg/PoseWithCovarianceStamped"


async def test_robots_are_localised_once_their_nodes_are_active(tmp_path: Path, router: str) -> None:
    initial: list[Any] = []
    states = {"/amcl": 2, "/bt_navigator": 2}  # inactive

    def state_of(node: str) -> Offer:
        return service(f"{node}/get_state", "lifecycle_msgs/srv/GetState", {"current_state": {"id": states[node]}})

    async def localise(servers: Servers) -> None:
        node = servers.node
        async with (
            node.subscribing("/initialpose", POSES) as asked,
            node.publishing("/amcl_pose", POSES) as poses,
            node.publishing("/amcl/transition_event", "lifecycle_msgs/msg/TransitionEvent") as amcl,
            node.publishing("/bt_navigator/transition_event", "lifecycle_msgs/msg/TransitionEvent") as navigator,
        ):
            for transitions in (amcl, navigator):
                await transitions.wait_for_subscription()
                transitions.publish({"start_state": {"id": 2}, "goal_state": {"id": 3, "label": "active"}})
                if transitions is amcl:
                    initial.append(await asked.message())
                    poses.publish({"header": {"frame_id": "map"}})

    text = (
        f"import osc.nav2\nscenario main:\n    robot: differential_drive_robot\n    do robot.init_nav2({POSE})\n"
    )
    with anyio.fail_after(LIMIT):
        async with (
            serving(router, definitions("jazzy"), [state_of("/amcl"), state_of("/bt_navigator")]) as servers,
            anyio.create_task_group() as tasks,
        ):
            tasks.start_soon(localise, servers)
            async with running(tmp_path, router, text) as started:
                ran = await ran_of(started)
            tasks.cancel_scope.cancel()
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert (initial[0].header.frame_id, initial[0].pose.pose.position.y) == ("map", 2.0)
    assert initial[0].pose.covariance[35] == pytest.approx(0.0685)


async def test_speeds_are_limited_by_a_topic(tmp_path: Path, router: str) -> None:
    text = (
        "import osc.nav2\nscenario main:\n    robot: differential_drive_robot\n    do serial:\n"
        "        robot.limit_speed(0.5mps)\n        robot.limit_speed_share(0.25)\n"
    )
    with anyio.fail_after(LIMIT):
        async with (
            serving(router, definitions("jazzy"), []) as servers,
            servers.node.subscribing("/speed_limit", "nav2_msgs/msg/SpeedLimit") as limits,
            running(tmp_path, router, text) as started,
        ):
            ran = await ran_of(started)
            found = [await limits.message() for _ in range(2)]
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert [(each.percentage, each.speed_limit) for each in found] == [(False, 0.5), (True, 25.0)]

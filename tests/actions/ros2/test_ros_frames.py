"""Actions of `osc.ros` on where a robot and its frames are."""

import re

import pytest

from seoro.actions.ros_frames import _Time
from seoro.bridges.ros2.clock import MachineClock
from seoro.errors import UsageError
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import RunRos, failing_after

ROBOT = "scenario main:\n    robot: differential_drive_robot\n"


@pytest.mark.parametrize(
    "invocation",
    [
        "robot.tf_close_to(0.2m, position_3d(x: 10.5m))",
        "robot.tf_close_to(0.1m, position_3d(x: 0.5m), parent_frame_id: 'odom')",
        "robot.odometry_distance_traveled(0.3m)",
        pytest.param("assert_tf_moving('base_link', timeout: 5s, duration: 0.6s)", marks=pytest.mark.more),
    ],
)
async def test_a_moving_robot_arrives(invocation: str, run_ros: RunRos) -> None:
    ran = await run_ros(f"{ROBOT}    do {invocation} with:\n        timeout(20s)\n")
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason


@pytest.mark.parametrize(
    ("invocation", "missing"),
    [
        pytest.param(
            "robot.tf_close_to(0.2m, position_3d(x: 20m))",
            "`base_link` within 0.2 m of the point; it is [0-9.]+ m away",
            marks=pytest.mark.more,
        ),
        (
            "robot.tf_close_to(0.2m, position_3d(), robot_frame_id: 'base_lin')",
            "a pose of `base_lin` in `map`: unknown frame `base_lin`; did you mean `base_link`",
        ),
        pytest.param(
            "robot.tf_close_to(0.2m, position_3d(), namespace_override: 'r2')",
            "unknown frame `base_link`: no frame was published",
            marks=pytest.mark.more,
        ),
        pytest.param(
            "robot.odometry_distance_traveled(1m, namespace_override: '/r1')",
            "1 m on /r1/odom; found 0 m",
            marks=pytest.mark.more,
        ),
    ],
)
async def test_a_robot_that_does_not_arrive_reports_its_distance(
    invocation: str, missing: str, run_ros: RunRos
) -> None:
    moved = 4 * ['wait_for_data("/tf", "tf2_msgs/msg/TFMessage")']
    ran = await run_ros(ROBOT + failing_after(invocation, *moved))
    assert ran.verdict.status is RunStatus.FAILED
    assert any(re.search(missing, text) for _, text in ran.logs), ran.logs


async def test_an_invalid_position_adds_no_distance(run_ros: RunRos) -> None:
    call = "robot.odometry_distance_traveled(1m, namespace_override: 'lost')"
    ran = await run_ros(f"{ROBOT}    do {call} with:\n        timeout(20s)\n")
    assert ran.verdict.status is RunStatus.FAILED
    assert "invalid position on /lost/odom: x nan, y 0" in ran.verdict.reason


async def test_topics_of_an_actor_are_in_its_namespace(run_ros: RunRos) -> None:
    ran = await run_ros(
        """
scenario main:
    robot: differential_drive_robot with:
        keep(it.namespace == '/r1')
    do robot.odometry_distance_traveled(1m) with:
        timeout(0.3s)
"""
    )
    assert "1 m on /r1/odom" in ran.logs[-1][1]


@pytest.mark.parametrize(
    ("invocation", "reason"),
    [
        ("'box', timeout: 0s", "invalid `timeout`: expected more than 0 s, found 0 s"),
        ("'box', timeout: 0.5s", "`box` has not moved in `map` for 0.5 s: 0 m/s and 0 rad/s"),
        pytest.param(
            "'box', timeout: 0.4s, use_sim_time: true",
            "`box` has not moved in `map` for 0.4 s",
            marks=pytest.mark.more,
        ),
        pytest.param(
            "'base_link', timeout: 0.5s, threshold_translation: 50mps",
            "`base_link` has not moved in `map` for 0.5 s",
            marks=pytest.mark.more,
        ),
        pytest.param(
            "'bus', timeout: 0.5s, wait_for_first_transform: false",
            "unknown frame `bus`; known frames: `base_link`, `box`",
            marks=pytest.mark.more,
        ),
        (
            "'bus', timeout: 0.8s, wait_for_first_transform: false, use_sim_time: true",
            "unknown frame `bus`; known frames: `base_link`, `box`",
        ),
    ],
)
async def test_a_frame_at_rest_fails(invocation: str, reason: str, run_ros: RunRos) -> None:
    ran = await run_ros(f"scenario main:\n    do assert_tf_moving({invocation})\n")
    assert ran.verdict.status is RunStatus.FAILED
    assert reason in ran.verdict.reason


async def test_driving_actions_need_a_bridge(run_ros: RunRos) -> None:
    with pytest.raises(UsageError, match=r"the ROS 2 system at .*, the backend of `robot`, does not support"):
        await run_ros(f"import osc.driving\n{ROBOT}    do robot.drive(0.1mps, duration: 1s)\n")


async def test_late_messages_are_not_awaited() -> None:
    clock = _Time(MachineClock())
    before = clock.now()
    await clock.wait_until(before - 1.0)
    assert clock.now() - before < 1.0

"""Actions of `osc.ros` that check the values of messages."""

from pathlib import Path

import anyio
import pytest

from seoro.actions.ros_checks import is_logger_of
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import Qos, RmwZenoh
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import (
    RunRos,
    expect_failure,
    failing_after,
    ran_of,
    run_with_a_robot_that_dies,
    running,
)

SCAN_TYPE, EMPTY = '"sensor_msgs/msg/LaserScan"', '"std_msgs/msg/Empty"'
COUNT = '"/count", "std_msgs/msg/Int64"'
SCAN = '"/scan", "sensor_msgs/msg/LaserScan"'


@pytest.mark.parametrize(
    "invocation",
    [
        f'check_data({COUNT}, "3", member_name: "data", comparison_operator: comparison_operator!gt)',
        f'check_data({COUNT}, "{{data: -1}}", comparison_operator: comparison_operator!ne)',
        f'check_data({SCAN}, "{{ranges: [1.0, 2.5]}}", qos_profile: qos_preset_profiles!sensor_data)',
        f'check_data({SCAN}, "laser", eval_expected_value: false, member_name: "header.frame_id")',
        f'check_data({SCAN}, "2.5000001", member_name: "ranges.1", fail_if_bad_comparison: true)',
        f'check_data({COUNT}, "0", comparison_operator: comparison_operator!ge, member_name: "data",'
        " fail_if_no_data: true, wait_for_first_message: false)",
    ],
)
async def test_data_that_compares_is_found(
    invocation: str, run_ros: RunRos, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.actions.ros_checks.DATA_WITHIN", 20.0)  # as long as a busy machine may take
    ran = await run_ros(f"scenario main:\n    do {invocation} with:\n        timeout(20s)\n")
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason


@pytest.mark.parametrize(
    ("invocation", "reason"),
    [
        (
            f'check_data({SCAN}, "{{header: {{frame_id: base}}, ranges: [1.0, 3]}}",'
            " fail_if_bad_comparison: true)",
            "a message of /scan differs: `header.frame_id`: expected `base`, got `laser`; "
            "`ranges.1`: expected `3`, got `2.5`",
        ),
        (
            f'check_data({COUNT}, "-5", comparison_operator: comparison_operator!lt, member_name: "data",'
            " fail_if_bad_comparison: true)",
            "`data` of /count is `.*`; expected < `-5`",
        ),
        (f'check_data({COUNT}, "x", comparison_operator: comparison_operator!lt)', "has no order with `x`"),
        (
            f'check_data({SCAN}, "{{header: {{frame: base}}}}", comparison_operator: comparison_operator!ne)',
            "a message of /scan: unknown member `header.frame`",
        ),
        (
            f'check_data("/silent", {EMPTY}, "", fail_if_no_data: true, wait_for_first_message: false)',
            "no message on /silent within 0.2 s",
        ),
        (
            f'assert_topic_latency("/scan", 1ms, topic_type: {SCAN_TYPE})',
            "the latency of /scan is 0.0[0-9]+ s; expected <= 0.001 s",
        ),
        (
            f'assert_topic_latency("/scan", 1ms, rolling_average_count: 3, topic_type: {SCAN_TYPE})',
            "the latency of /scan, the mean of 3 messages, is 0.0[0-9]+ s",
        ),
        (
            'assert_topic_latency("/count", 1s, topic_type: "std_msgs/msg/Int64")',
            "unknown latency of /count: its messages have no header with a stamp",
        ),
        (
            'assert_topic_latency("/odom", 1s, topic_type: "nav_msgs/msg/Odometry")',
            "unknown latency of /odom: the stamps of its messages are 0",
        ),
        (
            'assert_topic_latency("/scan", 1ms)',
            "the latency of /scan is 0.0[0-9]+ s; expected <= 0.001 s",
        ),
        (
            'assert_topic_latency("/scan", 1s, wait_for_first_message: false)',
            "missing `topic_type`, which `wait_for_first_message: false` needs",
        ),
        (
            f'assert_topic_latency("/silent", 0.2s, wait_for_first_message: false, topic_type: {EMPTY})',
            "no message on /silent within 0.2 s",
        ),
    ],
)
async def test_unexpected_values_are_shown(
    invocation: str, reason: str, run_ros: RunRos, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.actions.ros_checks.DATA_WITHIN", 0.2)
    ran = await run_ros(f"scenario main:\n    do {invocation} with:\n        timeout(20s)\n")
    expect_failure(ran.verdict, reason)


async def test_a_cancelled_check_shows_the_last_values(run_ros: RunRos) -> None:
    check = f'check_data({COUNT}, "-1", member_name: "data")'
    ran = await run_ros("scenario main:\n" + failing_after(check, *3 * [f"wait_for_data({COUNT})"]))
    [(_, text)] = ran.logs
    assert text.startswith("`check_data` ends without: `data` of /count differs: expected `-1`, got `")


async def test_a_small_latency_holds_until_it_is_ended(run_ros: RunRos) -> None:
    ran = await run_ros(
        """
scenario main:
    do parallel:
        assert_topic_latency("/scan", 1s, topic_type: "sensor_msgs/msg/LaserScan", duration: 0.3s)
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason


async def test_logs_of_a_node_are_found(run_ros: RunRos) -> None:
    ran = await run_ros(
        """
scenario main:
    event found
    do parallel:
        serial:
            log_check("robot", ["received a whisper", "nothing"])
            emit found
        topic_publish("/texts", "std_msgs/msg/String", "{data: a whisper}") with:
            until @found
            repeat()
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason


async def test_logs_in_a_burst_are_found(tmp_path: Path, robot: str) -> None:
    text = 'scenario main:\n    do log_check("chatty", ["the sixth"])\n'
    async with (
        connect(robot, dialect=RmwZenoh()) as system,
        system.node("chatty") as node,
        node.publishing("/rosout", "rcl_interfaces/msg/Log", Qos(depth=1000)) as logs,
        running(tmp_path, robot, text) as run,
    ):
        with anyio.fail_after(30.0):
            await logs.wait_for_subscription()
            for number in range(300):
                logs.publish({"name": "chatty", "msg": "the sixth" if number == 5 else f"line {number}"})
            ran = await ran_of(run)
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason


@pytest.mark.parametrize(
    ("node", "loggers"),
    [
        ("", {"robot", "bot1.robot", "bot2.robot", "bot1.other"}),
        ("robot", {"robot", "bot1.robot", "bot2.robot"}),
        ("/robot", {"robot"}),
        ("/bot1/robot", {"bot1.robot"}),
        ("bot1.robot", {"bot1.robot"}),
        ("bot", set()),
    ],
)
def test_log_checks_accept_the_usual_node_names(node: str, loggers: set[str]) -> None:
    known = ("robot", "bot1.robot", "bot2.robot", "bot1.other")
    assert {logger for logger in known if is_logger_of(logger, node)} == loggers


async def test_logs_are_found_by_the_full_name_of_their_node(tmp_path: Path, robot: str) -> None:
    text = 'scenario main:\n    do log_check("/bot1/chatty", ["hello"])\n'
    async with (
        connect(robot, dialect=RmwZenoh()) as system,
        system.node("chatty", "/bot1") as node,
        node.publishing("/rosout", "rcl_interfaces/msg/Log", Qos(depth=1000)) as logs,
        running(tmp_path, robot, text) as run,
    ):
        with anyio.fail_after(30.0):
            await logs.wait_for_subscription()
            logs.publish({"name": "bot1.chatty", "msg": "hello"})
            ran = await ran_of(run)
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason


def change(state: str, *, once_watched: bool = False) -> str:
    """A call that changes the state of the robot, possibly only when its present state was asked for."""
    request = f"{{transition: {{id: {int(once_watched)}, label: {state}}}}}"
    return f'service_call("/robot/change_state", "lifecycle_msgs/srv/ChangeState", "{request}")'


def watch(states: str) -> str:
    return f'assert_lifecycle_state("/robot", [{states}], keep_running: false)'


STATES = ", ".join(f"lifecycle_state!{name}" for name in ("unconfigured", "inactive", "active"))


async def test_states_of_a_node_are_followed(run_ros: RunRos) -> None:
    ran = await run_ros(
        f"""
scenario main:
    do serial:
        {change("unconfigured")}
        parallel:
            {watch(STATES)}
            serial:
                {change("inactive", once_watched=True)}
                {change("active")}
        parallel:
            assert_lifecycle_state("robot", [{STATES}], allow_initial_skip: true, duration: 0.2s)
"""
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason


@pytest.mark.parametrize(
    ("before", "after", "reason"),
    [
        ("active", "active", "/robot is active; expected unconfigured"),
        ("unconfigured", "active", "/robot is active; expected inactive after unconfigured"),
    ],
)
async def test_unexpected_states_fail(before: str, after: str, reason: str, run_ros: RunRos) -> None:
    ran = await run_ros(
        f"""
scenario main:
    do serial:
        {change(before)}
        parallel:
            {watch(STATES)} with:
                timeout(20s)
            {change(after, once_watched=True)}
"""
    )
    assert ran.verdict.status is RunStatus.FAILED
    assert reason in ran.verdict.reason


async def test_states_that_were_not_reached_are_logged_at_the_end(run_ros: RunRos) -> None:
    # The second check asks for the state after the transition, so the first one has seen the transition by then.
    steps = change("inactive", once_watched=True), watch("lifecycle_state!inactive")
    await run_ros(f"scenario main:\n    do {change('unconfigured')}\n")
    ran = await run_ros("scenario main:\n" + failing_after(watch(STATES), *steps))
    assert ran.verdict.status is RunStatus.FAILED
    assert [text for _, text in ran.logs][-1] == "`assert_lifecycle_state` ends without: /robot being active"


async def test_a_node_that_dies_does_not_keep_its_state(tmp_path: Path, router: str) -> None:
    text = """
scenario main:
    do parallel:
        assert_lifecycle_state("/robot", [lifecycle_state!unconfigured])
        serial:
            service_call("/add", "example_interfaces/srv/AddTwoInts", "")
            log("now")
"""
    verdict = await run_with_a_robot_that_dies(tmp_path, router, text)
    expect_failure(verdict, "/robot is gone; expected to stay unconfigured|/robot/get_state disappeared")


async def test_a_node_without_a_life_cycle_is_reported(run_ros: RunRos, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.bridges.ros2.clients.parameters.ANSWER_TIMEOUT", 0.1)
    ran = await run_ros(f'scenario main:\n    do assert_lifecycle_state("/talker", [{STATES}])\n')
    assert "no node /talker with a life cycle (nodes: /robot" in ran.verdict.reason

"""Actions of `osc.ros`, and their goals, on a robot that violates protocols."""

import time
from collections.abc import Iterator
from pathlib import Path

import anyio
import pytest

from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import ran_of, running, starting_robot
from tests.routers import routing
from tests.runtime.conftest import Ran

BROKEN = '"/broken", "example_interfaces/action/Fibonacci"'
LATCHED = "qos_preset_profiles!system_default_transient_local"
SILENT, STUBBORN, GARBLED, NO_RESULT, MUTE = range(1, 6)


@pytest.fixture(scope="module")
def broken(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The endpoint of a router behind which that robot is."""
    folder = str(tmp_path_factory.mktemp("definitions"))
    with routing() as endpoint, starting_robot(endpoint, "broken_robot", folder):
        yield endpoint


async def run(folder: Path, endpoint: str, text: str) -> Ran:
    with anyio.fail_after(60.0):
        async with running(folder, endpoint, f"scenario main:\n{text}\n") as started:
            return await ran_of(started)


def warnings(ran: Ran) -> list[str]:
    return [each["message"] for each in ran.records if each["kind"] == "log" and each["level"] == "warning"]


@pytest.mark.parametrize(
    ("invocation", "reason"),
    [
        (
            'wait_for_data("/garbage", "std_msgs/msg/String")',
            "invalid message on /garbage: std_msgs/msg/String: invalid or truncated message of 9 bytes",
        ),
        (
            'wait_for_data("/strange", "std_msgs/msg/String")',
            "/strange: the robot and seoro have different definitions of std_msgs/msg/String (robot RIHS01_",
        ),
        (
            'wait_for_data("/strange", "std_msgs/msg/Int32")',
            "/strange is of type std_msgs/msg/String, not std_msgs/msg/Int32",
        ),
        (
            'assert_topic_latency("/old", 1s, topic_type: "sensor_msgs/msg/LaserScan")',
            "unknown latency of /old: a stamp differs by 36",
        ),
        (
            'assert_tf_moving("base_link", timeout: 0.3s, tf_topic_namespace: "bad",'
            " wait_for_first_transform: false)",
            "unknown frame `base_link`: no frame was published",
        ),
    ],
)
async def test_unreadable_messages_are_reported(invocation: str, reason: str, tmp_path: Path, broken: str) -> None:
    ran = await run(tmp_path, broken, f"    do {invocation}")
    assert ran.verdict.status is RunStatus.FAILED
    assert reason in ran.verdict.reason
    assert ran.verdict.duration < 2.0


async def test_transforms_that_cannot_be_read_are_reported_once(tmp_path: Path, broken: str) -> None:
    text = '    do assert_tf_moving("base_link", timeout: 9s, tf_topic_namespace: "bad", duration: 2s)'
    ran = await run(tmp_path, broken, text)
    [(_, text)] = ran.logs
    assert text.startswith("invalid message on /bad/tf: tf2_msgs/msg/TFMessage: ")


@pytest.mark.more
@pytest.mark.parametrize(
    ("invocation", "reason"),
    [
        (f'action_call({BROKEN}, "{{order: {MUTE}}}")', "no response from /broken/_action/send_goal within 10 s"),
        (
            'set_node_parameter("/broken", "speed", "1")',
            "no response from /broken/get_parameter_types within 10 s",
        ),
        (
            'assert_lifecycle_state("/broken", [lifecycle_state!active])',
            "no response from /broken/get_state within 10 s",
        ),
    ],
)
async def test_a_node_that_never_answers_times_out(
    invocation: str, reason: str, tmp_path: Path, broken: str
) -> None:
    ran = await run(tmp_path, broken, f"    do {invocation}")
    assert ran.verdict.status is RunStatus.FAILED
    assert reason in ran.verdict.reason
    assert ran.verdict.duration < 13.0


@pytest.mark.more
@pytest.mark.parametrize(
    ("order", "message"),
    [
        (SILENT, ["the goal of /broken may continue: its server has not reported its end within 2 s"]),
        (STUBBORN, ["the goal of /broken may continue: no response from /broken/_action/cancel_goal within 2 s"]),
        (MUTE, ["the goal of /broken may continue: its server has not reported its end within 2 s"]),
    ],
)
async def test_goals_with_an_unknown_end_are_reported(
    order: int, message: list[str], tmp_path: Path, broken: str
) -> None:
    began = time.monotonic()
    text = f'    do action_call({BROKEN}, "{{order: {order}}}") with:\n        timeout(0.2s)'
    ran = await run(tmp_path, broken, text)
    assert "still running after 0.2 s" in ran.verdict.reason
    assert warnings(ran) == message
    assert time.monotonic() - began < 9.0  # a mute server times out later


async def test_invalid_feedback_does_not_end_a_goal(tmp_path: Path, broken: str) -> None:
    ran = await run(
        tmp_path,
        broken,
        f"""
    do parallel:
        serial:
            action_call({BROKEN}, "{{order: {GARBLED}}}", success_on_acceptance: true)
            wait elapsed(0.3s)
            log("it goes on")""",
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert warnings(ran)[0].startswith("invalid message on /broken/_action/feedback: ")
    assert "it goes on" in [text for _, text in ran.logs]


async def test_a_goal_with_an_invalid_result_is_canceled(tmp_path: Path, broken: str) -> None:
    ran = await run(
        tmp_path,
        broken,
        f"""
    do serial:
        action_call({BROKEN}, "{{order: {NO_RESULT}}}") with:
            inverter()
        check_data("/canceled", "std_msgs/msg/Int64", "{NO_RESULT}", member_name: "data",
                qos_profile: {LATCHED}) with:
            timeout(5s)""",
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason


@pytest.mark.more
async def test_images_of_10_megabytes_do_not_delay_a_run(tmp_path: Path, broken: str) -> None:
    ran = await run(
        tmp_path,
        broken,
        """
    var width: int = 0
    event enough
    do parallel:
        serial:
            wait elapsed(2s)
            emit enough
        topic_monitor("/flood", "sensor_msgs/msg/Image", width, member_name: "width",
                qos_profile: qos_preset_profiles!sensor_data) with:
            until @enough""",
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert ran.verdict.duration < 3.0
    assert [each for each in ran.records if each["kind"] == "variable" and each["value"] == 2000]

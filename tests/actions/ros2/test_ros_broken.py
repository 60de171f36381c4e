"""What becomes of actions of `osc.ros` on a robot that does what robots should not, and of its goals."""

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
            "a message on /garbage cannot be read: std_msgs/msg/String: the 9 bytes are no such message",
        ),
        (
            'wait_for_data("/strange", "std_msgs/msg/String")',
            "/strange: the robot's definition of std_msgs/msg/String is not the one here (theirs RIHS01_",
        ),
        (
            'wait_for_data("/strange", "std_msgs/msg/Int32")',
            "/strange is of type std_msgs/msg/String, not std_msgs/msg/Int32",
        ),
        (
            'assert_topic_latency("/old", 1s, topic_type: "sensor_msgs/msg/LaserScan")',
            "the latency of /old cannot be said: a stamp differs by 3600",
        ),
        (
            'assert_tf_moving("base_link", timeout: 0.3s, tf_topic_namespace: "bad",'
            " wait_for_first_transform: false)",
            "there is no frame `base_link`: nothing was told of any frame",
        ),
    ],
)
async def test_what_cannot_be_read_is_named(invocation: str, reason: str, tmp_path: Path, broken: str) -> None:
    ran = await run(tmp_path, broken, f"    do {invocation}")
    assert ran.verdict.status is RunStatus.FAILED
    assert reason in ran.verdict.reason
    assert ran.verdict.duration < 2.0


async def test_transforms_that_cannot_be_read_are_told_once(tmp_path: Path, broken: str) -> None:
    text = '    do assert_tf_moving("base_link", timeout: 9s, tf_topic_namespace: "bad", duration: 0.3s)'
    ran = await run(tmp_path, broken, text)
    [(_, text)] = ran.logs
    assert text.startswith("a message on /bad/tf cannot be read: tf2_msgs/msg/TFMessage: ")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("invocation", "reason"),
    [
        (f'action_call({BROKEN}, "{{order: {MUTE}}}")', "/broken/_action/send_goal has not responded within 10 s"),
        (
            'set_node_parameter("/broken", "speed", "1")',
            "/broken/get_parameter_types has not responded within 10 s",
        ),
        (
            'assert_lifecycle_state("/broken", [lifecycle_state!active])',
            "/broken/get_state has not responded within 10 s",
        ),
    ],
)
async def test_a_node_that_never_answers_is_given_up(
    invocation: str, reason: str, tmp_path: Path, broken: str
) -> None:
    ran = await run(tmp_path, broken, f"    do {invocation}")
    assert ran.verdict.status is RunStatus.FAILED
    assert reason in ran.verdict.reason
    assert ran.verdict.duration < 13.0


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "told"),
    [
        (SILENT, ["the goal of /broken may go on: its server has not said within 2 s that it has ended"]),
        (STUBBORN, ["the goal of /broken may go on: /broken/_action/cancel_goal has not responded within 2 s"]),
        (MUTE, ["the goal of /broken may go on: its server has not said within 2 s that it has ended"]),
    ],
)
async def test_goals_whose_end_nobody_knows_are_told(
    order: int, told: list[str], tmp_path: Path, broken: str
) -> None:
    began = time.monotonic()
    text = f'    do action_call({BROKEN}, "{{order: {order}}}") with:\n        timeout(0.2s)'
    ran = await run(tmp_path, broken, text)
    assert "still running after 0.2 s" in ran.verdict.reason
    assert warnings(ran) == told
    assert time.monotonic() - began < 9.0  # which is less than it takes until a mute server is given up


async def test_feedback_that_cannot_be_read_does_not_end_a_goal(tmp_path: Path, broken: str) -> None:
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
    assert warnings(ran)[0].startswith("a message on /broken/_action/feedback cannot be read: ")
    assert "it goes on" in [text for _, text in ran.logs]


async def test_a_goal_whose_result_makes_no_sense_is_canceled(tmp_path: Path, broken: str) -> None:
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


@pytest.mark.slow
async def test_images_of_10_megabytes_hold_nobody_up(tmp_path: Path, broken: str) -> None:
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

"""Actions of `osc.ros` that wait for something to be there."""

from pathlib import Path

import anyio
import pytest

from seoro.bridges.ros2.participant import BRIDGE, connect
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.cli.main import main
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import RunRos, ran_of, running, starting_robot


@pytest.mark.parametrize(
    "invocation",
    [
        'wait_for_nodes(["/robot", "talker"])',
        'wait_for_topics(["/count", "texts"])',
        'wait_for_services(["/add"])',
        'wait_for_topic_publisher("/count", "talker")',
        'wait_for_topic_subscription("/texts", "/robot")',
        'wait_for_service_server("/add", "robot")',
    ],
)
async def test_existing_entities_are_not_awaited(invocation: str, run_ros: RunRos) -> None:
    ran = await run_ros(f"scenario main:\n    do {invocation} with:\n        timeout(20s)\n")
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason


@pytest.mark.parametrize(
    ("invocation", "missing"),
    [
        ('wait_for_nodes(["/robot", "/walker"])', "node /walker (similar: /talker)"),
        ('wait_for_topics(["/counts"])', "topic /counts (similar: /count)"),
        ('wait_for_topic_publisher("/count", "robot")', "publisher of /count in the node /robot"),
        ('wait_for_service_server("/ad", "")', "server of /ad (similar: /add)"),
    ],
)
async def test_missing_entities_are_reported(invocation: str, missing: str, run_ros: RunRos) -> None:
    ran = await run_ros(f"scenario main:\n    do {invocation} with:\n        timeout(0.1s)\n")
    assert ran.verdict.status is RunStatus.FAILED
    name = invocation.partition("(")[0]
    assert [text for _, text in ran.logs] == [f"`{name}` ends without: {missing}"]


async def test_a_wait_ends_when_its_entity_appears(tmp_path: Path, router: str) -> None:
    text = 'scenario main:\n    do wait_for_nodes(["/robot"])\n'
    async with running(tmp_path, router, text) as run:
        while run.now < 0.2:
            assert run.verdict is None
            await anyio.sleep(0.05)
        with starting_robot(router):
            verdict = await run.result()
    assert verdict.status is RunStatus.PASSED


async def test_endpoints_of_a_bridge_of_seoro_are_not_those_of_a_robot(tmp_path: Path, router: str) -> None:
    text = """scenario main:
    do serial:
        wait_for_topic_subscription("/odom", "/seoro_bridge")
        wait_for_topics(["/odom"]) with:
            timeout(0.2s)
"""
    async with (
        connect(router, dialect=RmwZenoh()) as system,
        system.node(BRIDGE) as bridge,
        bridge.subscribing("/odom", "nav_msgs/msg/Odometry"),
        running(tmp_path, router, text) as run,
    ):
        ran = await ran_of(run)
    assert [text for _, text in ran.logs] == ["`wait_for_topics` ends without: topic /odom"]


async def test_an_empty_list_is_refused(run_ros: RunRos) -> None:
    ran = await run_ros("scenario main:\n    do wait_for_nodes()\n")
    assert "expected at least one name" in ran.verdict.reason


def test_a_missing_system_is_reported(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "main.osc"
    file.write_text('import osc.ros\nscenario main:\n    do wait_for_nodes(["a"])\n')
    assert main(["exec", str(file)]) == 2
    error = capsys.readouterr().err
    assert "the run has neither a simulator nor a robot" in error
    assert "reach a ROS 2 system with `--ros`" in error
    assert "--sim" not in error

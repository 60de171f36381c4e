"""Actions of `osc.ros` while the router restarts, and while messages arrive too fast."""

import re
import signal
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path

import anyio
import pytest
import yaml

from seoro.actions import ros_checks
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.bridges.session import Session
from seoro.embed import prepare
from seoro.embed.runs import Run
from seoro.runtime.verdict import RunStatus, Verdict
from tests.actions.ros2.conftest import options, ran_of, running, starting_robot
from tests.routers import as_if_elsewhere, free_endpoint, router_process
from tests.runtime.conftest import load_text


async def verdict_after_a_restart(folder: Path, text: str, router: str, endpoint: str) -> Verdict:
    """Run a scenario beside a robot, and restart the router after the first that the run logs.

    Args:
        folder: Folder for the scenario.
        text: The scenario.
        router: Endpoint at which the router listens.
        endpoint: Endpoint to which the run and the robot connect.
    """
    hub = Session(listen=router, gossip=True)
    with starting_robot(endpoint):
        async with running(folder, endpoint, text) as run:
            await logged(run)
            await anyio.sleep(0.5)
            await anyio.to_thread.run_sync(hub.close)
            await anyio.sleep(0.5)
            hub = Session(listen=router, gossip=True)
            with anyio.fail_after(30.0):
                verdict = await run.result()
    hub.close()
    return verdict


async def verdict_after_a_kill(folder: Path, text: str, endpoint: str) -> Verdict:
    """Run a scenario, and kill and start the router after the first that the run logs."""
    with ExitStack() as routers:
        router = routers.enter_context(router_process(endpoint))
        async with running(folder, endpoint, text) as run:
            await logged(run)
            router.kill()
            await anyio.to_thread.run_sync(routers.enter_context, router_process(endpoint))
            with anyio.fail_after(30.0):
                return await run.result()


async def logged(run: Run) -> None:
    """Wait until a run has logged something."""
    async for record in run.trace():
        if record["kind"] == "log":
            return


@pytest.mark.more
async def test_waits_continue_after_a_restart_of_the_router(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    text = """
scenario main:
    var last: int = 0
    do serial:
        wait_for_data("/count", "std_msgs/msg/Int64")
        log("there")
        topic_monitor("/count", "std_msgs/msg/Int64", last, member_name: "data", duration: 6s)
        wait_for_nodes(["/robot"])
        wait_for_data("/count", "std_msgs/msg/Int64")
        service_call("/add", "example_interfaces/srv/AddTwoInts", "{a: 1}")
"""
    verdict = await verdict_after_a_restart(tmp_path, text, endpoint, endpoint)
    assert verdict.status is RunStatus.PASSED, verdict.reason


@pytest.mark.more
@pytest.mark.parametrize(
    ("call", "called"),
    [
        ('service_call("/never", "std_srvs/srv/Empty", "{}")', "/never"),
        ('action_call("/fibonacci", "example_interfaces/action/Fibonacci", "{order: 5000}")', "/fibonacci/"),
    ],
)
async def test_a_lost_router_during_a_call_is_an_error_not_a_failure(
    tmp_path: Path, call: str, called: str
) -> None:
    endpoint = free_endpoint()
    text = f"""
scenario main:
    do parallel:
        log("there")
        {call} with:
            inverter()
"""
    verdict = await verdict_after_a_restart(tmp_path, text, endpoint, as_if_elsewhere(endpoint))
    assert verdict.status is RunStatus.ERROR, verdict.reason
    assert f"the connection to the ROS 2 system is lost: {called}" in verdict.reason


@pytest.mark.more
async def test_a_call_to_a_node_of_this_machine_outlasts_the_router(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    text = """
scenario main:
    do parallel:
        log("there")
        action_call("/fibonacci", "example_interfaces/action/Fibonacci", "{order: 46}")
"""
    verdict = await verdict_after_a_restart(tmp_path, text, endpoint, endpoint)
    assert verdict.status is RunStatus.PASSED, verdict.reason


@pytest.mark.parametrize(
    "wait",
    [
        'wait_for_data("/count", "std_msgs/msg/Int64") with:\n            timeout(4s)\n            inverter()',
        'wait_for_data("/count", "std_msgs/msg/Int64", duration: 4s)',
    ],
    ids=["timeout", "duration"],
)
async def test_a_wait_that_times_out_without_a_router_is_an_error(tmp_path: Path, wait: str) -> None:
    endpoint = free_endpoint()
    text = f"""
scenario main:
    do parallel:
        log("there")
        {wait}
"""
    with router_process(endpoint) as router:
        async with running(tmp_path, endpoint, text) as run:
            await logged(run)
            router.kill()
            with anyio.fail_after(30.0):
                verdict = await run.result()
    assert verdict.status is RunStatus.ERROR, verdict.reason
    assert "the connection to the ROS 2 system is lost" in verdict.reason


@pytest.mark.parametrize(
    "wait",
    [
        'wait_for_data("/count", "std_msgs/msg/Int64") with:\n            timeout(5s)\n            inverter()',
        'wait_for_data("/count", "std_msgs/msg/Int64", duration: 5s)',
        'check_data("/count", "std_msgs/msg/Int64", "4", fail_if_no_data: true, wait_for_first_message: false)',
        'assert_tf_moving("base_link", timeout: 5s, wait_for_first_transform: false)',
    ],
    ids=["timeout", "duration", "data", "frame"],
)
async def test_a_wait_that_times_out_after_an_outage_is_an_error(
    tmp_path: Path, wait: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(ros_checks, "DATA_WITHIN", 5.0)  # a router may take seconds to close on a busy machine
    endpoint = free_endpoint()
    text = f"""
scenario main:
    do parallel:
        log("there")
        {wait}
"""
    verdict = await verdict_after_a_kill(tmp_path, text, endpoint)
    assert verdict.status is RunStatus.ERROR, verdict.reason
    # On a slow machine, the router may come back after the end of the wait.
    assert re.search("the connection to the ROS 2 system (was lost meanwhile|is lost)", verdict.reason)


@pytest.mark.more
async def test_an_outage_before_a_wait_does_not_excuse_it(tmp_path: Path) -> None:
    endpoint = free_endpoint()
    text = """
scenario main:
    do serial:
        log("there")
        wait elapsed(10s)
        wait_for_data("/count", "std_msgs/msg/Int64") with:
            timeout(0.2s)
"""
    verdict = await verdict_after_a_kill(tmp_path, text, endpoint)
    assert verdict.status is RunStatus.FAILED, verdict.reason


@pytest.mark.more
async def test_a_goal_accepted_too_late_is_canceled(tmp_path: Path, router: str) -> None:
    text = """
scenario main:
    do serial:
        wait_for_data("/count", "std_msgs/msg/Int64")
        log("stop")
        wait elapsed(0.5s)
        action_call("/fibonacci", "example_interfaces/action/Fibonacci", "{order: 5000}") with:
            inverter()
        log("go on")
        check_data("/echo", "std_msgs/msg/String", "goal canceled", member_name: "data",
                qos_profile: qos_preset_profiles!system_default_transient_local) with:
            timeout(10s)
"""
    signals = {"stop": signal.SIGSTOP, "go on": signal.SIGCONT}
    with starting_robot(router) as robot:
        async with running(tmp_path, router, text) as run:
            async for record in run.trace():
                if record.get("message") in signals:
                    robot.send_signal(signals[str(record["message"])])
            verdict = await run.result()
    assert verdict.status is RunStatus.PASSED, verdict.reason


async def test_messages_of_a_restarted_robot_are_received(tmp_path: Path, router: str) -> None:
    text = """
scenario main:
    do serial:
        wait_for_data("/count", "std_msgs/msg/Int64")
        log("there")
        check_data("/count", "std_msgs/msg/Int64", "4", member_name: "data")
        service_call("/add", "example_interfaces/srv/AddTwoInts", "{a: 1}")
"""
    with starting_robot(router) as robot:
        async with running(tmp_path, router, text) as run:
            async for record in run.trace():
                if record["kind"] == "log":
                    break
            robot.kill()
            with starting_robot(router), anyio.fail_after(20.0):
                verdict = await run.result()
    assert verdict.status is RunStatus.PASSED, verdict.reason


async def test_a_publisher_that_restarts_during_a_recording_is_reported(tmp_path: Path, router: str) -> None:
    text = """
import osc.ros

scenario main:
    event killed
    do serial:
        bag_record(['/count'], timestamp_suffix: false)
        log("recording")
        wait @killed
        check_data("/count", "std_msgs/msg/Int64", "4", member_name: "data")
"""
    settings = replace(options(router), output_directory=tmp_path / "out", external=("killed",))
    with starting_robot(router) as robot:
        async with prepare(load_text(tmp_path, text, ()), settings) as run, run.running():
            async for record in run.trace():
                if record["kind"] == "log":
                    break
            robot.kill()
            robot.wait()
            await run.emit("killed")
            with starting_robot(router), anyio.fail_after(20.0):
                ran = await ran_of(run)
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    notes = [text for _, text in ran.logs if "publisher" in text]
    assert notes[0] == "/count has lost its publisher, /talker"
    assert notes[1] == "/count has a publisher again"
    folder = tmp_path / "out" / "rosbag2"
    custom = yaml.safe_load((folder / "metadata.yaml").read_text())["rosbag2_bagfile_information"]["custom_data"]
    assert custom["notes"].splitlines()[:2] == notes[:2]


@pytest.mark.more
async def test_a_flood_of_messages_does_not_delay_a_run(tmp_path: Path, router: str) -> None:
    text = """
scenario main:
    var size: int = 0
    event enough
    do parallel:
        serial:
            wait elapsed(1s)
            emit enough
        topic_monitor("/flood", "sensor_msgs/msg/Image", size, member_name: "width") with:
            until @enough
"""
    image = {"width": 640, "height": 480, "encoding": "rgb8", "step": 1920, "data": bytes(640 * 480 * 3)}
    async with (
        connect(router, dialect=RmwZenoh()) as system,
        system.node("camera") as node,
        node.publishing("/flood", "sensor_msgs/msg/Image") as flood,
    ):
        payload = system.types.encode("sensor_msgs/msg/Image", image)
        async with running(tmp_path, router, text) as run, anyio.create_task_group() as tasks:

            async def pour() -> None:
                while True:
                    flood.send(payload)
                    await anyio.sleep(0.001)

            tasks.start_soon(pour)
            records = [record async for record in run.trace()]
            tasks.cancel_scope.cancel()
        verdict = await run.result()
    assert verdict.status is RunStatus.PASSED, verdict.reason
    assert verdict.duration < 3.0
    changes = [record for record in records if record["kind"] == "variable" and record["value"] == 640]
    assert changes

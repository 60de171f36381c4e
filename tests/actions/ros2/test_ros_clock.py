"""Actions of `osc.ros` on a robot in a simulation with `/clock`, whose time jumps."""

import subprocess
from collections.abc import Iterator
from pathlib import Path

import pytest

from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import ran_of, running, starting_robot
from tests.routers import routing
from tests.runtime.conftest import Ran

SCAN = '"/scan", {limit}, topic_type: "sensor_msgs/msg/LaserScan"'


@pytest.fixture
def simulated() -> Iterator[tuple[str, subprocess.Popen[str]]]:
    """The endpoint of a router behind which a robot in a simulation is, and its process."""
    with routing() as endpoint, starting_robot(endpoint, "simulated_robot") as process:
        yield endpoint, process


async def run(
    folder: Path, simulated: tuple[str, subprocess.Popen[str]], text: str, jump: float | None = None
) -> Ran:
    """Run a scenario; the clock jumps when it logs something."""
    endpoint, process = simulated
    async with running(folder, endpoint, f"scenario main:\n{text}\n") as started:
        async for record in started.trace():
            if record["kind"] == "log" and jump is not None:
                assert process.stdin is not None
                process.stdin.write(f"{jump}\n")
                process.stdin.flush()
                break
        return await ran_of(started)


async def test_latencies_are_in_simulated_time(
    tmp_path: Path, simulated: tuple[str, subprocess.Popen[str]]
) -> None:
    latency = f"assert_topic_latency({SCAN.format(limit='0.5s')}, rolling_average_count: 5, duration: 0.5s)"
    ran = await run(tmp_path, simulated, f"    do parallel:\n        {latency}")
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    ran = await run(tmp_path, simulated, f"    do assert_topic_latency({SCAN.format(limit='10ms')})")
    assert ran.verdict.reason.startswith("`assert_topic_latency` failed: the latency of /scan is 0.0")


async def test_a_frame_without_new_transforms_is_detected_in_simulated_time(
    tmp_path: Path, simulated: tuple[str, subprocess.Popen[str]]
) -> None:
    ran = await run(
        tmp_path,
        simulated,
        "    do assert_tf_moving('bus', 'odom', 0.3s, wait_for_first_transform: false, use_sim_time: true)",
    )
    assert ran.verdict.reason.endswith("unknown frame `bus`; known frames: `base_link`, `odom`")


@pytest.mark.parametrize(
    ("jump", "reported"), [(-0.95, "/clock jumped back from 100"), (3600.0, "/clock jumped ahead from 100")]
)
async def test_a_jump_is_reported_once_and_a_jump_back_drops_earlier_transforms(
    jump: float, reported: str, tmp_path: Path, simulated: tuple[str, subprocess.Popen[str]]
) -> None:
    """Otherwise a frame would keep its old pose for almost a second, until stamps reach their old values."""
    ran = await run(
        tmp_path,
        simulated,
        f"""
    robot: differential_drive_robot
    event there
    do parallel:
        serial:
            robot.tf_close_to(0.1m, position_3d(x: 5m), parent_frame_id: 'odom')
            wait elapsed(0.2s)
            log("jump")
        serial:
            robot.tf_close_to(0.1m, position_3d(x: 10m), parent_frame_id: 'odom')
            log("arrived")
            wait elapsed(0.2s)
            emit there
        assert_topic_latency({SCAN.format(limit="5s")}) with:
            until @there
        assert_tf_moving('base_link', 'odom', timeout: 60s) with:
            until @there""",
        jump,
    )
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert [text.startswith(reported) for _, text in ran.logs if "clock" in text] == [True]
    times = {text: time for time, text in ran.logs}
    assert times["arrived"] - times["jump"] < 0.8

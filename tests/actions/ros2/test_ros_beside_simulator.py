"""A robot in a simulator and one of a ROS 2 system, in one run: each is where it is found."""

from pathlib import Path

import pytest

from seoro.embed import prepare
from seoro.embed.options import Options, Ros, Simulator
from seoro.runtime.verdict import RunStatus
from tests.actions.ros2.conftest import ran_of
from tests.runtime.conftest import load_text

TEXT = """import osc.ros
import osc.driving

scenario main:
    simulated: differential_drive_robot
    real: differential_drive_robot
    var sum: int = 0
    do parallel:
        simulated.drive(linear: 0.2mps, angular: 0radps, duration: 2s)
        simulated.odometry_distance_traveled(0.3m)
        serial:
            service_call("/add", "example_interfaces/srv/AddTwoInts", "{a: 1}", response_variable: sum,
                response_member_name: "sum")
            compare(sum, "==", 1)
            real.odometry_distance_traveled(0.2m)
        assert_topic_latency("/scan", 60s, topic_type: "sensor_msgs/msg/LaserScan", duration: 1s)
"""


@pytest.mark.more
@pytest.mark.engine("mujoco")
async def test_simulated_time_continues_while_a_robot_is_awaited(tmp_path: Path, robot: str) -> None:
    options = Options(seed=0, ros=Ros(robot), simulator=Simulator("mujoco", rate=1.0))
    async with prepare(load_text(tmp_path, TEXT, ()), options) as run, run.running():
        ran = await ran_of(run)
    assert ran.verdict.status is RunStatus.PASSED, ran.verdict.reason
    assert ran.ends["simulated.drive"] == "succeeded"
    assert ran.verdict.duration < 30.0

"""`osc.driving` and velocity commands, on simulator nodes."""

from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.integration.conftest import read_trace

pytestmark = pytest.mark.engine("mujoco")

SCENARIO = """
import osc.driving

scenario main:
    robot: differential_drive_robot
    do serial:
        robot.drive(linear: 0.3mps, angular: 0.2radps, duration: 1s)
        one_of:
            robot.drive(linear: -0.2mps, duration: 100s)
            wait elapsed(1s)
        topic_publish("/turtlebot4/cmd_vel", "geometry_msgs.msg.Twist", "{linear: {x: 0.2}}")
        topic_publish("/cmd_vel", "geometry_msgs.msg.Twist", velocity_6d(translational_velocity_3d(x: 0.2mps)))
        wait elapsed(1s)
        MORE
"""


def run(folder: Path, node: str, more: str = "wait elapsed(0s)") -> int:
    file = folder / "drive.osc"
    file.write_text(SCENARIO.replace("MORE", more))
    return main(["exec", str(file), "--connect", node, "--world", "empty", "--rate", "max", "-o", str(folder)])


def test_a_scenario_drives_a_robot(tmp_path: Path, mujoco_node: str) -> None:
    assert run(tmp_path, mujoco_node) == 0
    names = {r["id"]: r["name"] for r in read_trace(tmp_path / "trace.jsonl") if r["kind"] == "behavior.start"}
    ended = [
        (names[r["id"]], r["t"], r["status"])
        for r in read_trace(tmp_path / "trace.jsonl")
        if r["kind"] == "behavior.end" and names[r["id"]].startswith(("robot.", "topic"))
    ]
    assert ended == [
        ("robot.drive", 1.0, "succeeded"),
        ("robot.drive", 2.0, "cancelled"),
        ("topic_publish", 2.0, "succeeded"),
        ("topic_publish", 2.0, "succeeded"),
    ]


@pytest.mark.parametrize(
    ("action", "words"),
    [
        ("robot.drive(linear: 2mps, duration: 1s)", "expected up to 0.306 m/s"),
        pytest.param(
            'topic_publish("/odom", "geometry_msgs.msg.Twist", "{}")',
            "expected /cmd_vel for its first driven robot",
            marks=pytest.mark.more,
        ),
        pytest.param(
            'topic_publish("/cmd_vel", "std_msgs.msg.String", "data: hi")',
            "needs a ROS 2 system (`--ros`)",
            marks=pytest.mark.more,
        ),
        pytest.param(
            'topic_publish("/cmd_vel", "geometry_msgs.msg.Twist", "data: hi")',
            "invalid twist",
            marks=pytest.mark.more,
        ),
    ],
)
def test_impossible_actions_fail_with_a_reason(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], mujoco_node: str, action: str, words: str
) -> None:
    assert run(tmp_path, mujoco_node, action) == 1
    assert words in capsys.readouterr().err

"""`seoro ros` against a robot in another process."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import anyio
import pytest

from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.cli.main import main
from tests.routers import free_endpoint, process

pytest.importorskip("rosbags", reason="the extra ros2 is not installed")
pytest.importorskip("mcap", reason="the extra ros2 is not installed")
pytest.importorskip("xxhash", reason="the extra ros2 is not installed")

SCAN = "sensor_msgs/msg/LaserScan"


@dataclass(frozen=True)
class Robot:
    endpoint: str
    process: subprocess.Popen[bytes]

    def parameter(self) -> str:
        assert self.process.stdout is not None
        return self.process.stdout.readline().decode().strip()


@pytest.fixture(scope="module")
def robot() -> Iterator[Robot]:
    endpoint = free_endpoint()
    with process(str(Path(__file__).with_name("ros_robot.py")), endpoint) as running:
        yield Robot(endpoint, running)


Ros = Callable[..., tuple[int, str, str]]


@pytest.fixture
def ros(robot: Robot, capsys: pytest.CaptureFixture[str]) -> Ros:
    def call(*arguments: str) -> tuple[int, str, str]:
        status = main(["ros", *arguments, "--ros", robot.endpoint])
        out, err = capsys.readouterr()
        return status, out, err

    return call


def test_the_graph_lists_nodes_topics_services_and_actions(ros: Ros) -> None:
    status, out, _ = ros("graph")
    assert status == 0
    lines = [line.split() for line in out.splitlines()]
    assert ["/robot"] in lines
    assert ["/scan", SCAN, "1", "publisher", "no", "subscription"] in lines
    assert ["/cmd_vel", "geometry_msgs/msg/Twist", "no", "publisher", "1", "subscription"] in lines
    assert ["/enable", "std_srvs/srv/SetBool"] in lines
    assert ["/fibonacci", "example_interfaces/action/Fibonacci"] in lines
    assert "_action" not in out


def test_the_graph_is_json_on_request(ros: Ros) -> None:
    _, out, _ = ros("graph", "--json", "--all")
    graph = json.loads(out)
    assert graph["nodes"] == ["/robot"]
    assert {"name": "/scan", "types": [SCAN], "publishers": 1, "subscriptions": 0} in graph["topics"]
    assert any("_action" in service["name"] for service in graph["services"])


def test_a_node_is_shown_with_its_endpoints(ros: Ros) -> None:
    _, out, _ = ros("graph", "--node", "robot")
    assert out.startswith("/robot\npublishes (3)\n")
    assert "subscribes (1)\n  /cmd_vel  geometry_msgs/msg/Twist\n" in out


@pytest.mark.parametrize(
    ("arguments", "message", "hint"),
    [
        (("graph", "--node", "robt"), "unknown node /robt", "did you mean `/robot`?"),
        (("topic", "echo", "/scna"), "unknown topic /scna", "did you mean `/scan`?"),
        (("topic", "info", "/scna"), "unknown topic /scna", "did you mean `/scan`?"),
        (("topic", "echo", "/scan", "--field", "range"), "unknown member 'range' in 'range'", "ranges"),
        (
            ("topic", "pub", "/cmd_vel", "0.5"),
            "invalid value '0.5': expected a mapping of fields",
            "write it as YAML",
        ),
        (("topic", "pub", "/cmd_vel", "geometry_msgs/Twist", "{lin: 1}"), "`lin`", "did you mean `linear`?"),
        (("topic", "pub", "/cmd_vel", "linear:", "{x: 1}"), "unexpected argument 'linear:'", "write it as YAML"),
        (("topic", "pub", "/cmd_vel", "{lin: 1}"), "`lin`", "did you mean `linear`?"),
        (("topic", "pub", "/cmd_vel", "{linear: {x: fast}}"), "`linear.x`: expected a number", ""),
        (("service", "call", "/enabled"), "unknown service /enabled", "did you mean `/enable`?"),
        (("action", "send_goal", "/fibonaci"), "unknown action /fibonaci", "did you mean `/fibonacci`?"),
    ],
)
def test_invalid_names_are_rejected_with_suggestions(
    ros: Ros, arguments: tuple[str, ...], message: str, hint: str
) -> None:
    status, _, err = ros(*arguments)
    assert status == 2
    assert message in err
    assert hint in err


def test_topics_are_echoed_as_yaml_and_cut_off(ros: Ros) -> None:
    status, out, _ = ros("topic", "echo", "/scan", "--count", "2")
    assert status == 0
    assert out.count("---\n") == 2
    assert "header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: lidar\n" in out
    assert "1.5, '... 360 in all']" in out


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        (("--field", "ranges.3"), "1.5\n"),
        (("--field", "header.frame_id"), "lidar\n"),
        (("--field", "header.stamp", "--json"), '{"sec": 0, "nanosec": 0}\n'),
    ],
)
def test_members_are_echoed(ros: Ros, more: tuple[str, ...], expected: str) -> None:
    assert ros("topic", "echo", "scan", "-n", "1", *more) == (0, expected, "")


def test_full_messages_are_not_cut_off(ros: Ros) -> None:
    _, out, _ = ros("topic", "echo", "/scan", "-n", "1", "--full")
    assert out.count("1.5") == 360


def test_rates_are_measured(ros: Ros) -> None:
    status, out, _ = ros("topic", "hz", "/chatter", "-n", "20")
    assert status == 0
    assert 5.0 < float(out.split()[0]) < 100.0
    assert out.rstrip().endswith("window 20")


def test_rates_are_measured_for_programs(ros: Ros) -> None:
    _, out, _ = ros("topic", "hz", "/chatter", "-n", "20", "--json")
    found = [json.loads(line) for line in out.splitlines()]
    assert 5.0 < found[-1]["rate"] < 100.0
    assert found[-1]["messages"] == 20
    assert found[-1]["shortest"] <= 1.0 / found[-1]["rate"] <= found[-1]["longest"]


def test_bursts_are_shown_whole_whatever_their_publisher_keeps(ros: Ros) -> None:
    status, out, err = ros("topic", "echo", "/burst", "--field", "data", "-n", "100")
    assert (status, err) == (0, "")
    numbers = [int(line) for line in out.split()]
    assert numbers == list(range(numbers[0], numbers[0] + 100))


def test_info_shows_quality_of_service_and_definitions(ros: Ros) -> None:
    _, out, _ = ros("topic", "info", "/scan")
    assert out.splitlines()[0] == "1 publisher"
    assert "/robot" in out
    assert "best_effort, volatile, keeps last 5  same definition" in out


def test_info_is_printed_for_programs(ros: Ros) -> None:
    _, out, _ = ros("topic", "info", "/scan", "--json")
    found = json.loads(out)
    assert (found["topic"], found["type"], found["subscriptions"]) == ("/scan", "sensor_msgs/msg/LaserScan", [])
    [publisher] = found["publishers"]
    assert (publisher["node"], publisher["definition"]) == ("/robot", "same definition")
    assert (publisher["qos"]["reliability"], publisher["qos"]["depth"]) == ("best_effort", 5)


def test_messages_are_published(ros: Ros, robot: Robot) -> None:
    status, out, _ = ros("topic", "pub", "/cmd_vel", "{linear: {x: 0.25}}", "-n", "2", "--rate", "50")
    assert (status, out) == (0, "published 2 messages on /cmd_vel\n")
    assert [robot.parameter(), robot.parameter()] == ["0.25", "0.25"]


def test_publishing_fails_without_subscription(ros: Ros) -> None:
    status, out, err = ros("topic", "pub", "/unused", "std_msgs/msg/String", "{}", "--wait", "0.1")
    assert (status, out) == (3, "")
    assert "no subscription to /unused within 0.1 s" in err
    status, out, _ = ros("topic", "pub", "/unused", "std_msgs/msg/String", "{}", "--wait", "0")
    assert (status, out) == (0, "published 1 message on /unused\n")


def test_services_are_listed_and_called(ros: Ros) -> None:
    _, out, _ = ros("service", "list")
    assert ["/enable", "std_srvs/srv/SetBool"] in [line.split() for line in out.splitlines()]
    assert ros("service", "call", "/enable", "{data: true}") == (0, "success: true\nmessage: 'on'\n", "")
    assert ros("service", "call", "/enable", "std_srvs/srv/SetBool", "{data: true}")[0] == 0
    assert ros("service", "call", "/enable", "std_srvs/SetBool", "--json") == (
        0,
        '{"success": false, "message": "off"}\n',
        "",
    )


def test_goals_are_sent(ros: Ros) -> None:
    assert ros("action", "list") == (0, "/fibonacci  example_interfaces/action/Fibonacci\n", "")
    status, out, _ = ros("action", "send_goal", "/fibonacci", "{order: 5}")
    assert (status, out.splitlines()) == (
        0,
        ["/fibonacci accepted the goal", "succeeded", "  sequence: [0, 1, 1, 2, 3]"],
    )
    status, out, _ = ros("action", "send_goal", "/fibonacci", "{order: 500}")
    assert (status, out) == (1, "the server of /fibonacci rejects the goal\n")


def ended(robot: Robot, number: signal.Signals, begun: str, *arguments: str) -> tuple[int, str]:
    """Send a signal to a command after its expected first line; return its exit status and stderr."""
    command = [sys.executable, "-m", "seoro", "ros", *arguments, "--ros", robot.endpoint]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        assert running.stderr is not None
        try:
            assert begun in (running.stdout.readline() if begun.startswith("/") else running.stderr.readline())
            running.send_signal(number)
            _, err = running.communicate(timeout=60.0)
        finally:
            running.kill()
    return running.returncode, err


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_signals_cancel_a_goal_with_a_message(number: signal.Signals, robot: Robot) -> None:
    status, err = ended(robot, number, "/fibonacci accepted", "action", "send_goal", "/fibonacci", "{order: 50}")
    assert (status, err) == (128 + number, "the goal was canceled\n")


@pytest.mark.parametrize(
    ("order", "reported"),
    [
        (60, "warning: the goal of /fibonacci may continue: its server rejects to cancel it\n"),
        (70, "the goal had already ended (succeeded)\n"),
    ],
    ids=["rejected", "ended by itself"],
)
def test_rejected_cancellations_are_reported(order: int, reported: str, robot: Robot) -> None:
    goal = ("action", "send_goal", "/fibonacci", f"{{order: {order}}}")
    assert ended(robot, signal.SIGTERM, "/fibonacci accepted", *goal) == (143, reported)


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGHUP])
def test_bags_are_complete_when_a_signal_ends_recording(
    number: signal.Signals, robot: Robot, tmp_path: Path
) -> None:
    recording = ("bag", "record", "/chatter", "-o", str(tmp_path / "bag"))
    assert ended(robot, number, "recording to", *recording)[0] == 0
    assert (tmp_path / "bag" / "metadata.yaml").exists()  # the last file that is written


async def test_publishing_ends_by_signals(robot: Robot) -> None:
    message = ["std_msgs/msg/String", "{data: hello}"]
    command = [sys.executable, "-m", "seoro", "ros", "topic", "pub", "/beat", *message]
    more = ["--rate", "50", "--ros", robot.endpoint]
    async with (
        connect(robot.endpoint, dialect=RmwZenoh()) as system,
        system.node("listener") as node,
        node.subscribing("/beat", "std_msgs/msg/String") as beats,
    ):
        with subprocess.Popen([*command, *more], stdout=subprocess.PIPE) as running, anyio.fail_after(60.0):
            await beats.message()
            running.send_signal(signal.SIGTERM)
            assert await anyio.to_thread.run_sync(running.wait) == 0


def test_parameters_are_shown_and_set(ros: Ros) -> None:
    _, out, _ = ros("param", "get", "robot")
    assert out == "max_particles: 2000\nrobot_model: differential\nweights: [0.5, 0.25]\n"
    assert ros("param", "get", "/robot", "robot_model") == (0, "differential\n", "")
    assert ros("param", "set", "robot", "max_particles", "3000") == (
        0,
        "max_particles of /robot is now 3000\n",
        "",
    )
    assert ros("param", "set", "robot", "max_particles", "2000")[0] == 0


def test_parameters_rejected_by_a_node_are_reported(ros: Ros) -> None:
    status, _, err = ros("param", "set", "robot", "max_particles", "-1")
    assert status == 2
    assert "it has to be positive" in err
    status, _, err = ros("param", "get", "robot", "max_particle")
    assert status == 2
    assert "/robot has no parameter `max_particle` (parameters: max_particles)" in err
    status, _, err = ros("param", "get", "robt")
    assert status != 0
    assert "unknown node /robt" in err
    assert "did you mean `/robot`?" in err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("topic", "echo", "/scan", "-n", "0"), "expected a whole number from 1, found '0'"),
        (("topic", "pub", "/a", "{}", "--rate", "nan"), "expected a positive number, found 'nan'"),
        (("graph", "--domain", "300"), "invalid domain ID '300': expected 0 to 232"),
        (("topic", "echo", "/scan", "--once"), "unknown option `--once` of `seoro ros topic echo`"),
        (("graph", "--dialect", "dds"), "unknown value `dds` of `--dialect`"),
    ],
)
def test_wrong_command_lines_are_refused(
    arguments: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    with pytest.raises(SystemExit) as ended:
        main(["ros", *arguments])
    assert ended.value.code == 2
    assert message in capsys.readouterr().err


@pytest.mark.parametrize("domain", ["many", "1" * 5_000])
def test_a_wrong_domain_of_the_environment_is_refused(
    domain: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", domain)
    assert main(["ros", "graph"]) == 2
    assert "environment variable ROS_DOMAIN_ID: invalid domain ID" in capsys.readouterr().err


def test_an_unreachable_system_is_reported(capsys: pytest.CaptureFixture[str]) -> None:
    endpoint = free_endpoint()
    assert main(["ros", "graph", "--ros", endpoint]) in (2, 3)
    assert f"cannot connect to {endpoint}" in capsys.readouterr().err


def test_topics_are_recorded_and_played(ros: Ros, tmp_path: Path) -> None:
    from seoro.bridges.ros2.recording import open_bag

    folder = str(tmp_path / "drive")
    status, out, err = ros("bag", "record", "scan", "-o", folder, "--duration", "0.3")
    assert (status, err) == (0, f"recording to {folder}; Ctrl-C ends it\n")
    assert out.startswith(f"{folder}: ")
    count = open_bag(Path(folder)).topics["/scan"].count
    assert count > 0
    status, out, _ = ros("bag", "play", folder, "--rate", "1000")
    assert (status, out) == (0, f"/scan: {count} message{'' if count == 1 else 's'}\n")


def test_all_topics_are_recorded_on_request(ros: Ros, tmp_path: Path) -> None:
    folder = str(tmp_path / "all")
    status, out, _ = ros("bag", "record", "--all", "-o", folder, "--duration", "0.3")
    assert status == 0
    assert "/scan " in out
    assert "/chatter " in out


def test_invalid_recordings_are_rejected(ros: Ros, tmp_path: Path) -> None:
    status, _, err = ros("bag", "record")
    assert status == 2
    assert "error: no topics to record" in err
    status, out, err = ros("bag", "record", "/scan", "-o", str(tmp_path))
    assert (status, out) == (2, "")
    assert "exists; expected a new folder" in err
    status, _, err = ros("bag", "play", str(tmp_path / "none"))
    assert status == 2
    assert "bag not found" in err

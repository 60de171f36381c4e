"""`seoro accept` of ROS 2 bags."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from seoro.bridges.ros2.recording.metadata import BagTopic
from seoro.cli.main import main
from tests.bridges.ros2.recording.bags import CHATTER, LATCHED, SCAN, SECOND, TYPES, text, write

pytestmark = pytest.mark.anyio

TF = "tf2_msgs/msg/TFMessage"
MAP = BagTopic("/mode", CHATTER.type, CHATTER.type_hash, (LATCHED,))
HEAD = "import osc.helpers\nimport osc.ros\nscenario monitor:\n    robot: differential_drive_robot\n"


def transform(x: float) -> bytes:
    message = {
        "header": {"frame_id": "map"},
        "child_frame_id": "base_link",
        "transform": {"translation": {"x": x}, "rotation": {"w": 1.0}},
    }
    return TYPES.encode(TF, {"transforms": [message]})


@pytest.fixture
async def bag(tmp_path: Path) -> Path:
    """A robot that drives from 0 to 5 m at 1 m/s, counts ten times a second, and is late once."""
    frames = BagTopic("/tf", TF, TYPES.type_hash(TF), ())
    scans = BagTopic("/scan", SCAN, TYPES.type_hash(SCAN), ())
    messages = [(MAP.name, text("auto"), 0)]
    for step in range(51):
        at = step * SECOND // 10
        late = SECOND // 2 if step == 40 else 0
        stamp = {"sec": 1_700_000_000 + (at - late) // SECOND, "nanosec": (at - late) % SECOND}
        messages.append((CHATTER.name, text(str(step)), at))
        messages.append(("/tf", transform(step / 10), at))
        messages.append(("/scan", TYPES.encode(SCAN, {"header": {"stamp": stamp}}), at))
    return await write(tmp_path / "field", messages, CHATTER, MAP, frames, scans)


def accept(bag: Path, body: str, capsys: pytest.CaptureFixture[str]) -> tuple[int, str]:
    file = bag.parent / "monitor.osc"
    file.write_text(HEAD + body)
    status = main(["accept", str(bag), str(file)])
    found = capsys.readouterr()
    return status, found.out + found.err


STRING = '"std_msgs/msg/String"'
PASSING = [
    f'do wait_for_data("/chatter", {STRING})',
    f'do check_data("/chatter", {STRING}, "42", member_name: "data", eval_expected_value: false)',
    "do robot.tf_close_to(20cm, position_3d(x: 3m))",
    f"""do serial:
        wait elapsed(2s)
        check_data("/mode", {STRING}, "auto", member_name: "data", eval_expected_value: false)
        check_data("/chatter", {STRING}, "21", member_name: "data", eval_expected_value: false, \\
            fail_if_bad_comparison: true)""",
    """do parallel(duration: 3.5s):
        assert_topic_latency("/scan", 0.1s, topic_type: "sensor_msgs/msg/LaserScan")""",
]


@pytest.mark.parametrize("body", PASSING)
def test_what_happened_satisfies_the_scenario(body: str, bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, output = accept(bag, f"    {body}\n", capsys)
    assert status == 0, output
    assert f"accepted: {bag}" in output


@pytest.mark.parametrize(
    ("body", "status", "reason"),
    [
        (
            f'do check_data("/chatter", {STRING}, "99", member_name: "data", eval_expected_value: false)',
            1,
            "ends after 5.000 s",
        ),
        ('do assert_topic_latency("/scan", 0.1s)', 1, "the latency of /scan is 0.5 s"),
        (
            'do assert_topic_latency("/scan", 0.1s, topic_type: "sensor_msgs/msg/LaserScan")',
            1,
            "the latency of /scan is 0.5 s",
        ),
        (
            'do wait_for_data("/scan", "std_msgs/msg/String")',
            1,
            "/scan is of type sensor_msgs/msg/LaserScan in the bag",
        ),
        ('do wait_for_data("/chat", "std_msgs/msg/String")', 1, "has no topic /chat; did you mean"),
        ("do robot.nav_to_pose(pose_3d())", 2, "does not support `differential_drive_robot.nav_to_pose`"),
        ("do service_call('/a', 'std_srvs/srv/Empty', '{}')", 2, "cannot carry out `service_call`"),
    ],
)
def test_failures_and_commands_are_refused(
    body: str, status: int, reason: str, bag: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    found, output = accept(bag, f"    {body}\n", capsys)
    assert (found, reason in output) == (status, True), output


def test_the_result_is_json_on_request(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = bag.parent / "monitor.osc"
    file.write_text(HEAD + "    do wait elapsed(2.5s)\n")
    assert main(["accept", "--json", str(bag), str(file)]) == 0
    assert json.loads(capsys.readouterr().out) == {"accepted": True, "reason": "", "duration": 2.5}


def test_the_observation_has_a_trace(bag: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file, trace = bag.parent / "monitor.osc", bag.parent / "trace.jsonl"
    file.write_text(HEAD + f'    do wait_for_data("/chatter", {STRING})\n')
    assert main(["accept", str(bag), str(file), "--trace", str(trace)]) == 0
    assert main(["accept", str(trace), str(file)]) == 0
    assert main(["accept", str(trace), str(file), "--trace", str(trace)]) == 2
    assert "`--trace` needs a bag" in capsys.readouterr().err


def test_a_damaged_bag_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag, file = tmp_path / "a.mcap", tmp_path / "monitor.osc"
    bag.write_bytes(b"nothing")
    file.write_text(HEAD + "    do wait elapsed(1s)\n")
    assert main(["accept", str(bag), str(file)]) == 2
    assert "a.mcap" in capsys.readouterr().err


POSE, TRANSITION = "geometry_msgs/msg/PoseWithCovarianceStamped", "lifecycle_msgs/msg/TransitionEvent"
STATES = {"unconfigured": 1, "inactive": 2, "active": 3, "configuring": 10, "activating": 13}


def place(x: float, second: float) -> bytes:
    at = round(second * 1e9)
    message = {
        "header": {"frame_id": "map", "stamp": {"sec": at // SECOND, "nanosec": at % SECOND}},
        "child_frame_id": "base_link",
        "transform": {"translation": {"x": x}, "rotation": {"w": 1.0}},
    }
    return TYPES.encode(TF, {"transforms": [message]})


def transition(start: str, goal: str) -> bytes:
    states = {
        f"{end}_state": {"id": STATES[name], "label": name} for end, name in (("start", start), ("goal", goal))
    }
    return TYPES.encode(TRANSITION, states)


@pytest.fixture
async def drive(tmp_path: Path) -> Path:
    """A robot that drives for 2 s and stands for 3 s. It is localised at 1 s, and a node becomes active."""
    topics = [
        BagTopic(name, type_name, TYPES.type_hash(type_name), qos)
        for name, type_name, qos in (
            ("/tf", TF, ()),
            ("/amcl_pose", POSE, (LATCHED,)),
            ("/planner/transition_event", TRANSITION, ()),
        )
    ]
    messages = [("/tf", place(min(step / 10, 2.0), step / 10), step * SECOND // 10) for step in range(51)]
    messages.append(("/amcl_pose", TYPES.encode(POSE, {}), SECOND))
    for second, start, goal in (
        (1.0, "unconfigured", "configuring"),
        (1.1, "configuring", "inactive"),
        (2.0, "inactive", "activating"),
        (2.5, "activating", "active"),
    ):
        messages.append(("/planner/transition_event", transition(start, goal), round(second * SECOND)))
    return await write(tmp_path / "drive", sorted(messages, key=lambda each: each[2]), *topics)


MOVING = 'assert_tf_moving("base_link", "map", {})'
LIFE = 'assert_lifecycle_state("/planner", [{}], keep_running: false)'
BECOMES_ACTIVE = LIFE.format(
    ", ".join(f"lifecycle_state!{name}" for name in ("unconfigured", "inactive", "active"))
)


@pytest.mark.parametrize("rate", ["", "use_sim_time: true, "])
def test_a_recorded_frame_moves(drive: Path, rate: str, capsys: pytest.CaptureFixture[str]) -> None:
    """The time of the bag counts, not that of the machine."""
    moving = MOVING.format(f"{rate}timeout: 1s")
    for _ in range(2):
        status, output = accept(drive, f"    do parallel(duration: 2.9s):\n        {moving}\n", capsys)
        assert status == 0, output
    status, output = accept(drive, f"    do {moving}\n", capsys)
    assert (status, "has not moved in `map` for 1 s" in output) == (1, True), output
    trace = drive.parent / "trace.jsonl"
    assert main(["accept", str(drive), str(drive.parent / "monitor.osc"), "--trace", str(trace)]) == 1
    end = json.loads(trace.read_text().splitlines()[-1])
    assert end["t"] == pytest.approx(3.0, abs=0.21)  # after the last window of 0.2 s with motion


def test_a_recorded_robot_is_localised(drive: Path, capsys: pytest.CaptureFixture[str]) -> None:
    head, body = "    do serial:\n", "        robot.wait_for_localization()\n"
    file = drive.parent / "monitor.osc"
    for before, seconds in (("", 1.0), ("        wait elapsed(3s)\n", 3.0)):
        file.write_text(
            HEAD.replace("import osc.ros", "import osc.ros\nimport osc.localization") + head + before + body
        )
        assert main(["accept", "--json", str(drive), str(file)]) == 0
        assert json.loads(capsys.readouterr().out)["duration"] == seconds


@pytest.mark.parametrize(
    ("body", "duration"),
    [
        (BECOMES_ACTIVE, 2.5),
        (
            "serial:\n        wait elapsed(1.5s)\n        "
            + LIFE.format("lifecycle_state!inactive, lifecycle_state!active"),
            2.5,
        ),
        (f"serial:\n        wait elapsed(3s)\n        {LIFE.format('lifecycle_state!active')}", 3.0),
    ],
)
def test_a_recorded_node_goes_through_its_states(
    drive: Path, body: str, duration: float, capsys: pytest.CaptureFixture[str]
) -> None:
    file = drive.parent / "monitor.osc"
    file.write_text(f"{HEAD}    do {body}\n")
    assert main(["accept", "--json", str(drive), str(file)]) == 0
    assert json.loads(capsys.readouterr().out)["duration"] == duration


@pytest.mark.parametrize(
    ("body", "reason"),
    [
        (LIFE.format("lifecycle_state!active"), "/planner is unconfigured; expected active"),
        (LIFE.replace("planner", "plan").format("lifecycle_state!active"), "has no topic /plan/transition_event"),
        (
            f"serial:\n        wait elapsed(1s)\n        {LIFE.format('lifecycle_state!active')}",
            "/planner is inactive",
        ),
    ],
)
def test_other_states_fail(drive: Path, body: str, reason: str, capsys: pytest.CaptureFixture[str]) -> None:
    status, output = accept(drive, f"    do {body}\n", capsys)
    assert (status, reason in output) == (1, True), output

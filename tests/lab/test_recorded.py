"""Recorded robots of a lab."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

import seoro
from seoro.bridges.ros2.recording.metadata import BagTopic
from seoro.bundle.pack import pack
from seoro.cli.main import main
from seoro.embed.options import Options
from seoro.lab.reading import read_lab
from tests.bridges.ros2.recording.bags import CHATTER, SECOND, TYPES, text, write

pytestmark = pytest.mark.anyio

TF = "tf2_msgs/msg/TFMessage"
ODOMETRY = "nav_msgs/msg/Odometry"
GOALS, STATUS = "navigate_to_pose/_action/status", "action_msgs/msg/GoalStatusArray"
HEAD = "import osc.helpers\nimport osc.ros\nscenario field:\n    tb: differential_drive_robot\n"
LAB = "robots:\n  tb: {kind: bag, bag: drive, namespace: /tb}\n"


async def record(folder: Path, tf: str = "/tb/tf", odom: str = "/tb/odom", frame: str = "base_link") -> Path:
    """Make a lab with a recorded robot that drives from 0 to 5 m at 1 m/s, in a namespace."""
    frames = BagTopic(tf, TF, TYPES.type_hash(TF), ())
    odometry = BagTopic(odom, ODOMETRY, TYPES.type_hash(ODOMETRY), ())
    goals = BagTopic(f"/tb/{GOALS}", STATUS, TYPES.type_hash(STATUS), ())
    messages = []
    for second, status in ((1, 2), (4, 4)):
        payload = TYPES.encode(STATUS, {"status_list": [{"status": status}]})
        messages.append((goals.name, payload, second * SECOND))
    for step in range(51):
        at, x = step * SECOND // 10, step / 10
        place = {"translation": {"x": x}, "rotation": {"w": 1.0}}
        transform = {"header": {"frame_id": "map"}, "child_frame_id": frame, "transform": place}
        messages.append((CHATTER.name, text(str(step)), at))
        messages.append((tf, TYPES.encode(TF, {"transforms": [transform]}), at))
        pose = {"pose": {"pose": {"position": {"x": x}}}}
        messages.append((odom, TYPES.encode(ODOMETRY, pose), at))
    messages.sort(key=lambda each: each[2])
    await write(folder / "drive", messages, CHATTER, frames, odometry, goals)
    (folder / "lab.yaml").write_text(LAB)
    return folder


@pytest.fixture
async def folder(tmp_path: Path) -> Path:
    return await record(tmp_path)


def execute(folder: Path, body: str, capsys: pytest.CaptureFixture[str], *options: str) -> tuple[int, str]:
    file = folder / "field.osc"
    file.write_text(f"{HEAD}    do {body}\n")
    status = main(["exec", str(file), "--lab", str(folder / "lab.yaml"), "--rate", "max", *options])
    found = capsys.readouterr()
    return status, found.out + found.err


@pytest.mark.parametrize(
    ("body", "duration"),
    [
        ("tb.tf_close_to(25cm, position_3d(x: 3m))", "2.80 s"),
        ("tb.odometry_distance_traveled(1.95m)", "2.00 s"),
        ('wait_for_data("/chatter", "std_msgs/msg/String")', "0.00 s"),
        (f'check_data("/tb/{GOALS}", "{STATUS}", "{{status_list: [{{status: 4}}]}}")', "4.00 s"),
    ],
)
def test_a_recorded_robot_does_what_it_did(
    body: str, duration: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, output = execute(folder, body, capsys)
    assert status == 0, output
    assert f"passed  field in {duration}" in output


def test_a_run_observes_it_from_python(folder: Path) -> None:
    file = folder / "field.osc"
    file.write_text(f"{HEAD}    do tb.tf_close_to(20cm, position_3d(x: 9m))\n")
    verdict = seoro.run(seoro.load(file), lab=seoro.Lab(folder / "lab.yaml"))
    assert (verdict.passed, "ends after 5.000 s" in verdict.reason) == (False, True), verdict


def test_a_typed_robot_is_selected(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "lab.yaml").write_text(LAB.replace("tb:", "first:").replace("/tb}", "/tb, type: turtlebot4}"))
    body = "tb.tf_close_to(20cm, position_3d(x: 3m))"
    status, output = execute(folder, body, capsys, "--set", "tb=any:turtlebot4")
    assert (status, "`tb` is robot `first`" in output) == (0, False), output
    status, output = execute(folder, body, capsys)
    assert (status, "robots of the lab: first" in output) == (2, True), output


PROFILE = """
model: {model}
kinds: [differential_drive_robot, robot, osc_actor]
tf: /tf
base:
  limits: {{linear: 0.2, angular: 0.5}}
  odometry: controller/odom
"""


@pytest.fixture
async def shared(tmp_path: Path) -> Path:
    """A recorded robot as of ros2_control, in a fleet that shares its transforms."""
    return await record(tmp_path, "/tf", "/tb/controller/odom", "tb/base_link")


def test_a_profile_names_its_topics(shared: Path, capsys: pytest.CaptureFixture[str]) -> None:
    folder = shared
    body = """parallel:
        tb.odometry_distance_traveled(1.95m)
        tb.tf_close_to(25cm, position_3d(x: 3m), robot_frame_id: "tb/base_link")"""
    status, output = execute(folder, body, capsys)
    assert (status, "no topic /tb/odom" in output) == (1, True), output
    (folder / "lab.yaml").write_text(LAB.replace("/tb}", "/tb, profile: shared.yaml}"))
    (folder / "shared.yaml").write_text(PROFILE.format(model="tb"))
    status, output = execute(folder, body, capsys, "-o", str(folder / "out"))
    assert (status, "passed  field in 2.80 s" in output) == (0, True), output
    records = [json.loads(line) for line in (folder / "out" / "trace.jsonl").read_text().splitlines()]
    assert {name for each in records if each["kind"] == "poses" for name in each["entities"]} == {"tb"}
    sent = pack(seoro.load(folder / "field.osc"), Options(lab=seoro.Lab(folder / "lab.yaml"))).manifest.files
    assert "shared.yaml" in {each.path for each in sent}


@pytest.mark.parametrize(
    ("body", "options", "reason"),
    [
        ("tb.nav_to_pose(pose_3d())", (), "a recorded robot obeys no commands"),
        ("tb.nav_to_pose(pose_3d())", (), f"check how its own goals ended, with `check_data` on /tb/{GOALS}"),
        ("service_call('/a', 'std_srvs/srv/Empty', '{}')", (), "cannot carry out `service_call`"),
        ("wait elapsed(1s)", ("--ros",), "recorded robots contradict a ROS 2 system"),
        ("wait elapsed(1s)", ("--clock", "real"), "impossible with a bag"),
    ],
)
def test_commands_are_refused_before_the_run(
    body: str, options: tuple[str, ...], reason: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, output = execute(folder, body, capsys, *options)
    assert (status, reason in output) == (2, True), output


@pytest.mark.parametrize(
    ("robots", "reason"),
    [
        ("tb: {kind: bag}", "needs both `kind: bag` and `bag`"),
        ("tb: {type: turtlebot4}", "expected either `in`"),
        ("tb: {kind: bag, bag: drive, limits: {speed: 1}, as: a}", "obeys no commands: remove limits, as"),
        ("tb: {kind: bag, bag: drive}\n  other: {kind: bag, bag: a}", "the recorded robots of a lab have one bag"),
        ("tb: {kind: bag, bag: missing}", "lab.yaml:2: robots.tb: "),
        ("tb: {kind: bag, bag: drive, namespace: /tb1}", "lab.yaml:2: robots.tb: the bag"),
        ("two: {kind: bag, bag: drive}", "lab.yaml:2: unknown actor 'two'"),
        (
            "tb: {in: hall, profile: turtlebot4}",
            "profile: only for a recorded robot: remove it, or add `kind: bag`",
        ),
        ("tb: {kind: bag, bag: drive, profile: tb5}", "lab.yaml:2: robots.tb.profile: unknown profile 'tb5'"),
        ("tb: {kind: bag, bag: drive, profile: tb.yaml}", "robots.tb.profile: "),
    ],
)
def test_invalid_labs_are_refused(
    robots: str, reason: str, folder: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (folder / "lab.yaml").write_text(f"robots:\n  {robots}\n")
    status, output = execute(folder, "wait elapsed(1s)", capsys)
    assert (status, reason in output) == (2, True), output


def test_executors_receive_the_bag(folder: Path) -> None:
    file = folder / "field.osc"
    file.write_text(f"{HEAD}    do wait elapsed(1s)\n")
    lab = seoro.Lab(folder / "lab.yaml")
    assert read_lab(lab.file).endpoints == ()
    sent = {each.path for each in pack(seoro.load(file), Options(lab=lab)).manifest.files}
    assert "drive/metadata.yaml" in sent
    assert len(sent) == len([*(folder / "drive").iterdir()]) + 2

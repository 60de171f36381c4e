"""Recorded robots beside simulated and real ones."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from seoro.bridges.ros2.recording.metadata import BagTopic
from seoro.cli.main import main
from tests.bridges.robot.conftest import Rails
from tests.bridges.ros2.recording.bags import SECOND, TYPES, write

pytestmark = pytest.mark.anyio

TF = "tf2_msgs/msg/TFMessage"
HEAD = """import osc.driving
import osc.helpers
import osc.ros
scenario field:
    timeout(60s)
    tb: differential_drive_robot
    own: differential_drive_robot
"""
RECORDED = "robots:\n  tb: {kind: bag, bag: drive, namespace: /tb}\n"
SIMULATED = (
    f"simulators:\n  hall: {{simulator: mujoco, world: empty}}\n{RECORDED}  own: {{in: hall, as: turtlebot4}}\n"
)


async def record(folder: Path, seconds: int) -> Path:
    """Record a robot that drives at 1 m/s for a time."""
    frames = BagTopic("/tb/tf", TF, TYPES.type_hash(TF), ())
    messages = []
    for step in range(seconds * 10 + 1):
        place = {"translation": {"x": step / 10}, "rotation": {"w": 1.0}}
        header = {"frame_id": "map", "stamp": {"sec": step // 10, "nanosec": step % 10 * SECOND // 10}}
        transform = {"header": header, "child_frame_id": "base_link", "transform": place}
        messages.append(("/tb/tf", TYPES.encode(TF, {"transforms": [transform]}), step * SECOND // 10))
    await write(folder / "drive", messages, frames)
    return folder


@pytest.fixture
async def folder(tmp_path: Path) -> Path:
    """A lab with a recorded robot that drives from 0 to 5 m."""
    return await record(tmp_path, 5)


@pytest.fixture
async def short(tmp_path: Path) -> Path:
    """A lab with a recorded robot that drives from 0 to 1 m."""
    return await record(tmp_path, 1)


def execute(
    folder: Path, lab: str, body: str, capsys: pytest.CaptureFixture[str], *options: str
) -> tuple[int, str]:
    (folder / "lab.yaml").write_text(lab)
    file = folder / "field.osc"
    file.write_text(f"{HEAD}    do {body}\n")
    status = main(["exec", str(file), "--lab", str(folder / "lab.yaml"), "--seed", "1", *options])
    found = capsys.readouterr()
    return status, found.out + found.err


BOTH = "parallel:\n        own.drive(0.3mps, duration: {})\n        tb.tf_close_to(25cm, position_3d(x: {}))"


@pytest.mark.engine("mujoco")
@pytest.mark.parametrize(
    ("body", "status", "text"),
    [
        (BOTH.format("1s", "3m"), 0, "passed  field in 2.80"),
        (BOTH.format("6s", "3m"), 0, "passed  field in 6.0"),
        (
            "serial:\n        wait elapsed(2s)\n        tb.tf_close_to(25cm, position_3d(x: 2m))",
            0,
            "field in 2.00 s",
        ),
        (BOTH.format("6s", "9m"), 1, "ends after 5.000 s, and an action still observes it"),
        ("tb.nav_to_pose(pose_3d())", 2, "a recorded robot obeys no commands"),
    ],
)
def test_a_simulator_is_the_clock_of_a_recorded_robot(
    folder: Path, body: str, status: int, text: str, capsys: pytest.CaptureFixture[str]
) -> None:
    found, output = execute(folder, SIMULATED, body, capsys, "--rate", "max")
    assert (found, text in output) == (status, True), output


@pytest.mark.engine("mujoco")
def test_runs_beside_a_simulator_are_equal(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    traces = [folder / "a.jsonl", folder / "b.jsonl"]
    moving = 'assert_tf_moving("base_link", "map", timeout: 1s, tf_topic_namespace: "tb", duration: 4s)'
    body = f"{BOTH.format('2s', '3m')}\n        {moving}"
    for trace in traces:
        options = ("--rate", "max", "--trace", str(trace))
        assert execute(folder, SIMULATED, body, capsys, *options)[0] == 0
    assert main(["compare", *map(str, traces)]) == 0
    records = [json.loads(line) for line in traces[0].read_text().splitlines()]
    robots = {each["entity"]["name"]: each["entity"]["real"] for each in records if each["kind"] == "entity"}
    assert robots["tb"]
    ways = [(each["time"], each["entities"]["tb"]) for each in records if "tb" in each.get("entities", {})]
    assert len(ways) == 41
    for time, pose in ways[2:]:
        assert pose[0] == pytest.approx(time, abs=1e-3)  # it drives at 1 m/s
        assert pose[7] == pytest.approx(1.0, abs=1e-3)


def test_the_machine_is_the_clock_beside_a_real_robot(
    rails: Rails, short: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    lab = f"bridges:\n  floor: {{connect: {rails.endpoint}}}\n{RECORDED}  own: {{in: floor, as: line}}\n"
    body = BOTH.replace("0.3mps", "0.1mps").format("0.2s", "0.75m")
    status, output = execute(short, lab, body, capsys)
    assert status == 0, output
    assert float(output.partition("passed  field in ")[2].partition(" s")[0]) >= 0.49
    status, output = execute(short, lab, "tb.tf_close_to(25cm, position_3d(x: 9m))", capsys)
    assert (status, "ends after 1.000 s, and an action still observes it" in output) == (1, True), output
    status, output = execute(short, lab, "tb.drive(0.1mps, duration: 1s)", capsys)
    assert (status, "a recorded robot obeys no commands" in output) == (2, True), output


@pytest.fixture
def beside(rails: Rails, short: Path) -> Path:
    """A lab file with a real and a recorded robot."""
    file = short / "lab.yaml"
    real = f"bridges:\n  floor: {{connect: {rails.endpoint}}}\n"
    file.write_text(
        f"{real}{RECORDED.replace('namespace', 'type: cart, namespace')}  own: {{in: floor, as: line}}\n"
    )
    return file


def command(capsys: pytest.CaptureFixture[str], *arguments: object) -> tuple[int, str]:
    status = main([*map(str, arguments)])
    found = capsys.readouterr()
    return status, found.out + found.err


def test_the_status_of_a_lab_has_recorded_robots(beside: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bag = beside.parent / "drive"
    status, output = command(capsys, "lab", "status", "--lab", beside)
    rows = [line.split() for line in output.splitlines()]
    assert (status, [row[0] for row in rows]) == (0, ["ROBOT", "own", "tb"]), output
    assert rows[2][:9] == ["tb", "cart", "bag", str(bag), "(1.0", "s,", "1", "topic)", "recorded"]
    status, output = command(capsys, "lab", "status", "--json", "--lab", beside)
    [recorded] = json.loads(output)["recorded"]
    assert (recorded["name"], recorded["bag"], recorded["problem"]) == ("tb", str(bag), "")
    beside.write_text(beside.read_text().replace("/tb", "/other"))
    status, output = command(capsys, "lab", "status", "--lab", beside)
    assert (status, "unreadable" in output, "no topic in the namespace /other" in output) == (3, True, True), (
        output
    )


def test_recorded_robots_are_neither_leased_nor_stopped(beside: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for what in ("stop", "lease", "release"):
        status, output = command(capsys, "lab", what, "tb", "--lab", beside)
        assert (status, "cannot use 'tb': it is a recorded robot" in output) == (2, True), output
    status, output = command(capsys, "estop", "tb", "own", "--reason", "smoke", "--lab", beside)
    assert (status, "FAILED tb: it is a recorded robot" in output, "stopped line" in output) == (3, True, True), (
        output
    )
    release = ("lab", "release", "--estop", "own", "--yes", "--reason", "toast")
    assert command(capsys, *release, "--lab", beside)[0] == 0


def test_the_doctor_checks_the_bags_of_recorded_robots(beside: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, output = command(capsys, "doctor", "--lab", beside)
    assert f"ok       tb: recorded in the bag {beside.parent / 'drive'}: 1.0 s, 1 topic" in output
    beside.write_text(beside.read_text().replace("drive", "dive"))
    status, output = command(capsys, "doctor", "--lab", beside)
    assert (status, "robots.tb: bag not found" in output) == (1, True), output
    assert "= help: did you mean `drive`?" in output

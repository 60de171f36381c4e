"""`seoro ros adopt` on robots in other processes."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from seoro.bridges.ros2.robots.profile import read_profile
from seoro.cli.main import main
from seoro.lab.reading import read_lab
from tests.routers import free_endpoint, process, router_process

pytest.importorskip("rosbags", reason="the extra ros2 is not installed")

ROBOTS = Path(__file__).parents[1] / "bridges" / "ros2" / "robots"

Adopt = Callable[..., tuple[int, str, str]]


@pytest.fixture(scope="module")
def system(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Yield the endpoint of the router of a base and an arm."""
    folder, router = str(tmp_path_factory.mktemp("robots")), free_endpoint()
    with (
        router_process(router),
        process(str(ROBOTS / "fake_robot.py"), folder, router, "tb", "geometry_msgs/msg/TwistStamped"),
        process(str(ROBOTS / "fake_arm.py"), folder, router, "cell"),
    ):
        yield router


@pytest.fixture
def adopt(system: str, capsys: pytest.CaptureFixture[str]) -> Adopt:
    def call(*arguments: str) -> tuple[int, str, str]:
        status = main(["ros", "adopt", "--ros", system, *arguments])
        out, err = capsys.readouterr()
        return status, out, err

    return call


def test_files_of_all_robots_can_be_loaded(adopt: Adopt, system: str, tmp_path: Path) -> None:
    folder = tmp_path / "lab"
    status, out, _ = adopt("-o", str(folder), "--yes", "--bridge", "tcp/127.0.0.1:7999")
    assert status == 0
    lab = read_lab(folder / "lab.yaml")
    assert {name: (robot.where, robot.name_there, robot.type) for name, robot in lab.robots.items()} == {
        "cell": ("robots", "cell", "cell"),
        "tb": ("robots", "tb", "tb"),
    }
    assert lab.endpoints == ("tcp/127.0.0.1:7999",)
    base, arm = read_profile(str(folder / "tb.yaml")), read_profile(str(folder / "cell.yaml"))
    assert base.base is not None
    assert base.kinds == ("differential_drive_robot", "robot", "osc_actor")
    assert base.base.navigate_to_pose == "navigate_to_pose"
    assert arm.arm is not None
    expected = read_profile("ur10e").arm
    assert expected is not None
    assert arm.arm.joints.keys() == expected.joints.keys()
    assert arm.arm.trajectory == expected.trajectory
    assert arm.arm.gripper is not None
    assert expected.gripper is not None
    assert arm.arm.gripper.joint == expected.gripper.joint
    robots = f"--robot {folder}/cell.yaml:cell@/cell --robot {folder}/tb.yaml:tb@/tb"
    assert f"  seoro bridge ros2 {robots} --ros {system} --listen tcp/127.0.0.1:7999\n" in out
    assert f"wrote {folder}/tb.yaml (2 values to check)" in out
    assert "# CHECK: maximum forward speed [m/s]" in (folder / "tb.yaml").read_text()


def test_existing_files_are_kept(adopt: Adopt, tmp_path: Path) -> None:
    (tmp_path / "tb.yaml").write_text("mine")
    status, _, err = adopt("-o", str(tmp_path), "--namespace", "/tb")
    assert status == 2
    assert f"existing files: {tmp_path}/tb.yaml" in err
    assert "--force" in err
    assert [path.name for path in tmp_path.iterdir()] == ["tb.yaml"]
    assert adopt("-o", str(tmp_path), "--namespace", "tb", "--force")[0] == 0
    assert read_profile(str(tmp_path / "tb.yaml")).model == "tb"


def test_a_terminal_is_asked(adopt: Adopt, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    answers = iter(["Rover!", "rover", "fast", "0.4", ""])
    asked: list[str] = []

    def answer(question: str) -> str:
        asked.append(question)
        return next(answers)

    monkeypatch.setattr("sys.stdin.isatty", lambda: True)
    monkeypatch.setattr("builtins.input", answer)
    status, out, _ = adopt("-o", str(tmp_path), "--namespace", "/tb")
    assert status == 0
    assert asked == [
        *["name of the robot [tb] "] * 2,
        *["maximum forward speed [m/s] [0.2] "] * 2,
        "maximum turn rate [rad/s] [0.5] ",
    ]
    assert "invalid or used name 'Rover!'" in out
    assert "invalid answer 'fast': expected a number, such as 0.2" in out
    base = read_profile(str(tmp_path / "rover.yaml")).base
    assert base is not None
    assert (base.limits.linear, base.limits.angular) == (0.4, 0.5)
    text = (tmp_path / "rover.yaml").read_text()
    assert "# maximum forward speed [m/s], as answered" in text
    assert "# CHECK: maximum turn rate [rad/s]" in text


def test_unknown_namespaces_are_errors(adopt: Adopt, tmp_path: Path) -> None:
    status, _, err = adopt("-o", str(tmp_path / "none"), "--namespace", "/tb9")
    assert status == 2
    assert "no robot in the namespace /tb9" in err
    assert "namespaces of robots: /cell, /tb" in err
    assert not (tmp_path / "none").exists()


def test_a_system_without_robots_is_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.bridges.ros2.adoption.survey.START_TIMEOUT", 0.1)
    endpoint = free_endpoint()
    with process(str(Path(__file__).with_name("talking_node.py")), endpoint):
        assert main(["ros", "adopt", "--ros", endpoint, "-o", str(tmp_path)]) == 2
    err = capsys.readouterr().err
    assert "found 1 node, but no robot: nothing accepts geometry_msgs/msg/Twist" in err
    assert list(tmp_path.iterdir()) == []


def test_an_arm_without_names_of_joints_is_explained(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.bridges.ros2.adoption.survey.SETTLED_AFTER", 0.1)
    endpoint = free_endpoint()
    arm = ("arm", "control_msgs/action/FollowJointTrajectory")
    with process(str(Path(__file__).with_name("talking_node.py")), endpoint, *arm):
        assert main(["ros", "adopt", "--ros", endpoint, "-o", str(tmp_path), "--yes"]) == 2
    err = capsys.readouterr().err
    assert "no robot is described well enough: CHECK: /arm moves an arm" in err
    assert "start the publisher of its joint states" in err

"""Directives of a scenario file in `seoro exec`, here and on an executor, with a real simulator."""

from pathlib import Path

import pytest

from seoro.cli.main import main
from tests.executors import NAME, executor

pytestmark = pytest.mark.engine("mujoco")

WORLD = (
    "name: yard\nextent: [-2, -2, 2, 2]\nrobots:\n  - {name: rover, robot: turtlebot4, pose: {x: 0.5, y: 0.5}}\n"
)
SCENARIO = """# seoro: simulators mujoco
# seoro: world worlds/yard.yaml
# seoro: seed 7

import osc.ros
import osc.driving

scenario main:
    cart: differential_drive_robot
    do cart.drive(linear: 0.3mps, duration: 100ms)
"""


@pytest.fixture(autouse=True)
def _project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "worlds").mkdir()
    (tmp_path / "worlds" / "yard.yaml").write_text(WORLD)
    (tmp_path / "test.osc").write_text(SCENARIO)


EXPECTED = "test.osc: seed 7, mujoco with world 'yard', actor `cart` is robot `rover`"


def test_exec_uses_the_directives_of_the_file(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", "test.osc", "--rate", "max"]) == 0
    assert EXPECTED in capsys.readouterr().out


@pytest.mark.more
def test_an_executor_gets_the_world_of_the_file(
    tmp_path_factory: pytest.TempPathFactory, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    with executor(tmp_path_factory.mktemp("x")) as running:
        monkeypatch.setenv("SEORO_EXECUTOR", running.endpoint)
        assert main(["exec", "test.osc", "--rate", "max", "--on", NAME]) == 0
    assert EXPECTED in capsys.readouterr().out


def test_options_override_directives(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", "test.osc", "--world", "empty", "--seed", "3", "--rate", "max"]) == 0
    assert "seed 3, mujoco with world 'empty'" in capsys.readouterr().out

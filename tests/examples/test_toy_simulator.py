"""The example of a simulator fulfils the rules, and is found after its installation."""

import asyncio
import importlib.util
import os
import re
import shutil
import sys
import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from seoro.bridges import wire
from seoro.bridges.conformance import check_backend
from seoro.bridges.wire.refusal import RequestRefused
from seoro.cli.main import main
from sim_nodes.check import check_physics, rules_for
from sim_nodes.simulator import Simulator
from sim_nodes.verbs import handle
from tests.bridges.nodes import running
from tests.installed_packages import add_entry_points

ROOT = Path(__file__).parents[2]
FOLDER = ROOT / "examples" / "toy_simulator"
OBSTACLE = str(ROOT / "scenarios" / "navigation" / "obstacle.osc")


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """Install the toy into a folder of packages, for this process and its children."""
    project = tomllib.loads((FOLDER / "pyproject.toml").read_text())["project"]
    lines = [
        f"[{group}]\n" + "".join(f"{name} = {target}\n" for name, target in entries.items())
        for group, entries in project["entry-points"].items()
    ]
    add_entry_points(tmp_path, project["name"], "\n".join(lines), "1.0.0")
    shutil.copy(FOLDER / "toy_simulator.py", tmp_path)
    monkeypatch.setenv(
        "PYTHONPATH", os.pathsep.join([str(tmp_path), *filter(None, [os.environ.get("PYTHONPATH")])])
    )
    monkeypatch.syspath_prepend(str(tmp_path))
    return tmp_path


@pytest.fixture
def engine() -> Iterator[Any]:
    """Return the class of its engine."""
    specification = importlib.util.spec_from_file_location("toy_simulator", FOLDER / "toy_simulator.py")
    assert specification is not None and specification.loader is not None
    module = importlib.util.module_from_spec(specification)
    sys.modules["toy_simulator"] = module
    specification.loader.exec_module(module)
    yield module.ToyEngine
    del sys.modules["toy_simulator"]


def test_the_toy_engine_fulfils_the_rules_for_its_parts(engine: Any) -> None:
    check_physics(engine)
    names = {rule.__name__ for rule in rules_for(engine())}
    assert {"robots_drive_straight", "rays_end_at_every_shape", "saving_changes_nothing"} <= names
    assert not {"bodies_fall_with_gravity", "joints_go_where_they_are_pulled", "pictures_change_nothing"} & names


def test_missing_parts_of_the_toy_engine_are_refused(engine: Any, tmp_path: Path) -> None:
    world = tmp_path / "cell.yaml"
    world.write_text(
        "name: cell\nextent: [-3, -3, 3, 3]\nrobots:\n  - {name: arm, robot: ur10e}\n", encoding="utf-8"
    )
    simulator = Simulator(engine(), "empty", 0)
    before = simulator.simulation
    with pytest.raises(RequestRefused, match="the engine toy lacks arms; the world cell has arm"):
        simulator.load(str(world), 0)
    hill = tmp_path / "hill.yaml"
    hill.write_text("name: hill\nextent: [-3, -3, 3, 3]\nterrain:\n  - {platform: {size: [1, 1], height: 0.1}}\n")
    with pytest.raises(RequestRefused, match="the engine toy lacks terrain; the world hill has some"):
        simulator.load(str(hill), 0)
    assert simulator.simulation is before
    request = wire.encode(wire.EntityName(name="turtlebot4/front"))
    with pytest.raises(RequestRefused, match="the engine toy does not render images"):
        handle(simulator, wire.GET_CAMERA_IMAGE.name, request)


@pytest.mark.more
def test_the_toy_node_fulfils_the_contracts(installed: Path) -> None:
    with running("toy", installed) as make:
        asyncio.run(check_backend(make))


@pytest.mark.more
@pytest.mark.usefixtures("installed")
def test_a_scenario_runs_in_the_toy_simulator() -> None:
    assert main(["exec", OBSTACLE, "--sim", "toy", "--rate", "max", "--seed", "3"]) == 0


@pytest.mark.usefixtures("installed")
def test_an_installed_toy_simulator_is_found(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenario = tmp_path / "drive.osc"
    scenario.write_text(
        "import osc.driving\n\nscenario main:\n    robot: differential_drive_robot\n"
        "    do robot.drive(linear: 0.2mps, duration: 1s)\n"
    )
    assert main(["exec", str(scenario), "--sim", "toy", "--world", "empty", "--rate", "max"]) == 0
    assert main(["exec", str(scenario), "--sim", "tay"]) == 2
    assert "simulators: mujoco, pybullet, toy" in capsys.readouterr().err


def test_a_toy_simulator_that_is_not_installed_is_unknown(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["exec", OBSTACLE, "--sim", "toy"]) == 2
    assert re.search(r"unknown simulator 'toy'", capsys.readouterr().err)

"""Force-torque sensors against known weights, in both engines."""

from __future__ import annotations

import re
import shutil
from pathlib import Path

import numpy as np
import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES
from sim_nodes.geometry import rotation_matrix
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes.client import ROBOT, Client
from tests.sim_nodes.sensors.bench import ROBOTS, latest, next_sample, room_with

ARM = "ur10e"
GRAVITY = 9.81
SENSOR = "  - {kind: force_torque, name: wrist_ft, link: %s, rate: 50%s}\n"
CELL = "name: cell\nextent: [-3, -3, 3, 3]\nrobots: [{name: ur10e, robot: arm.yaml}]\n"


def cell_with(folder: Path, sensor: str) -> str:
    shutil.copy(ROBOTS / "ur10e.urdf", folder)
    (folder / "arm.yaml").write_text((ROBOTS / "ur10e.yaml").read_text() + f"sensors:\n{sensor}")
    (folder / "cell.yaml").write_text(CELL)
    return str(folder / "cell.yaml")


def mass_beyond(link: str) -> float:
    """Return the mass of a link of the arm and of all links that hang on it [kg]."""
    text = (ROBOTS / "ur10e.urdf").read_text()
    masses = dict(re.findall(r'<link name="([^"]+)">.*?<mass value="([^"]+)"', text, re.DOTALL))
    pairs = re.findall(r'<parent link="([^"]+)"/>\s*<child link="([^"]+)"', text)
    return float(masses[link]) + sum(mass_beyond(child) for parent, child in pairs if parent == link)


def wrench_of(sample: wire.SensorSample) -> tuple[np.ndarray, np.ndarray]:
    assert sample.wrench is not None
    return tuple(  # type: ignore[return-value]
        np.array([each.x, each.y, each.z]) for each in (sample.wrench.force, sample.wrench.torque)
    )


@pytest.mark.parametrize("engine", ENGINES)
def test_the_weight_of_a_tool_is_measured(engine: str, tmp_path: Path) -> None:
    link = "gripper_palm"
    client = Client(cell_with(tmp_path, SENSOR % (link, "")), engine=engine)
    client.advance(1.0)
    force, _ = wrench_of(next_sample(client, "wrist_ft", ARM))
    assert np.linalg.norm(force) == pytest.approx(mass_beyond(link) * GRAVITY, rel=0.005)
    engine_ = client.simulator.simulation.engine
    _, turn = engine_.link_pose(ARM, link)
    assert rotation_matrix(turn) @ force == pytest.approx([0, 0, -mass_beyond(link) * GRAVITY], abs=0.3)


def test_both_engines_measure_the_same_wrench(tmp_path: Path) -> None:
    world = cell_with(tmp_path, SENSOR % ("gripper_palm", ""))
    arm = tmp_path / "arm.yaml"
    arm.write_text(arm.read_text().replace("wrist_1_joint, home: -1.5708", "wrist_1_joint, home: 0.0"))
    found = []
    for engine in ENGINES:
        client = Client(world, engine=engine)
        client.advance(1.0)
        found.append(np.concatenate(wrench_of(next_sample(client, "wrist_ft", ARM))))
    assert found[0] == pytest.approx(found[1], abs=0.1)
    assert np.abs(found[0][3:]).max() > 0.3  # the tool is level


def test_noise_and_faults_act_on_forces(tmp_path: Path) -> None:
    world = cell_with(tmp_path, SENSOR % ("gripper_palm", ", force_noise: 0.5, torque_noise: 0.02"))
    client = Client(world)
    for name, fault in (
        ("bias", wire.Bias(offset={wire.Quantity.FORCE: 2.0})),
        ("noise", wire.GaussianNoise(deviation={wire.Quantity.TORQUE: 0.1})),
        ("lost", wire.MessageLoss(probability=0.5)),
    ):
        request = wire.InjectFault(id=name, robot=ARM, device="wrist_ft", fault=fault, limit=60.0)
        client.ask(wire.INJECT_FAULT, request)
        assert client.run_until(name)[0].outcome is Outcome.SUCCEEDED


def test_a_force_can_be_waited_for(tmp_path: Path) -> None:
    client = Client(cell_with(tmp_path, SENSOR % ("gripper_palm", "")))
    weight = mass_beyond("gripper_palm") * GRAVITY
    for name, force in (("less", 0.8 * weight), ("more", 3.0 * weight)):
        client.ask(wire.WATCH_FORCE, wire.WatchForce(id=name, robot=ARM, sensor="wrist_ft", force=force))
    assert [each.id for each in client.advance(0.5).occurrences] == ["less"]


def test_loads_continue_from_snapshots(tmp_path: Path) -> None:
    world = cell_with(tmp_path, SENSOR % ("gripper_palm", ", force_noise: 0.5"))
    client = Client(world, 3)
    next_sample(client, "wrist_ft", ARM)
    snapshot = client.ask(wire.SAVE_STATE, wire.Empty())
    fork = Client(world, 4)
    fork.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot))
    for each in (client, fork):
        each.advance(0.5)
    assert latest(fork, "wrist_ft", ARM) == latest(client, "wrist_ft", ARM)


def test_a_force_sensor_needs_a_fixed_joint(tmp_path: Path) -> None:
    with pytest.raises(WorldError, match="'wrist_ft' is on 'base_link'; expected the child of a fixed joint"):
        load_world(room_with(tmp_path, SENSOR % ("base_link", "")))


def test_other_sensors_measure_no_force(tmp_path: Path) -> None:
    client = Client(room_with(tmp_path, SENSOR % ("rplidar_link", "")))
    with pytest.raises(RequestRefused, match="turtlebot4/imu is not a force-torque sensor"):
        client.ask(wire.WATCH_FORCE, wire.WatchForce(id="w", robot=ROBOT, sensor="imu", force=1.0))

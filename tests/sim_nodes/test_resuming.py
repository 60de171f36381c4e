"""Nodes started from a snapshot."""

from __future__ import annotations

import signal
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.__main__ import ENGINES, INVALID, main
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.test_node import start

pytestmark = pytest.mark.engine("mujoco")


def driving(engine: str = "mujoco") -> Client:
    """Return a client of a robot that drives."""
    client = Client("empty", 3, engine)
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.2, angular=0.3, duration=2.0))
    client.spawn("box", pose(2.0, 2.0, z=0.3))
    client.advance(0.5)
    return client


def save(client: Client) -> wire.Snapshot:
    return client.ask(wire.SAVE_STATE, wire.Empty())


@pytest.mark.parametrize("engine", ENGINES)
def test_a_simulator_started_from_a_snapshot_continues_identically(engine: str) -> None:
    original = driving(engine)
    resumed = Client(save(original), None, engine)
    features = resumed.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())
    assert (features.world, features.time, features.state) == ("empty", 0.5, wire.SimulationState.PAUSED)
    assert resumed.run_until("drive") == original.run_until("drive")
    assert resumed.truth == original.truth


def test_loading_without_a_name_loads_the_world_of_the_snapshot() -> None:
    resumed = Client(save(driving()), None)
    world = resumed.ask(wire.GET_CURRENT_WORLD, wire.Empty())
    assert (world.name, world.source) == ("empty", "")
    features = resumed.ask(wire.LOAD_WORLD, wire.LoadWorld(world="", seed=5))
    assert (features.world, features.time) == ("empty", 0.0)
    assert resumed.ask(wire.GET_ENTITIES, wire.EntityFilter()).names == (ROBOT,)
    resumed.ask(wire.LOAD_WORLD, wire.LoadWorld(world="hall"))
    assert resumed.ask(wire.GET_CURRENT_WORLD, wire.Empty()).source == "hall"


def test_stopping_returns_to_the_initial_state_of_the_world() -> None:
    resumed = Client(save(driving()), None)
    resumed.ask(wire.SET_SIMULATION_STATE, wire.SetSimulationState(state=wire.SimulationState.STOPPED))
    assert resumed.ask(wire.GET_ENTITIES, wire.EntityFilter()).names == (ROBOT,)
    assert resumed.simulator.time == 0.0
    assert resumed.truth.x == pytest.approx(0.0, abs=1e-6)


def test_another_seed_changes_the_rest_of_the_run() -> None:
    snapshot = save(driving())
    believed = set()
    for seed in (None, 3, 4):
        resumed = Client(snapshot, seed)
        resumed.advance(1.5)
        believed.add(resumed.simulator.simulation.robot(ROBOT).mobile.odometry.pose)
    assert len(believed) == 2


def test_snapshots_of_another_engine_or_version_are_refused() -> None:
    snapshot = save(driving())
    with pytest.raises(RequestRefused, match="requires the engine bullet; found mujoco"):
        Client(snapshot.model_copy(update={"engine": "bullet"}), None)
    with pytest.raises(RequestRefused, match=r"requires the version of seoro 0\.0\.1; found"):
        Client(snapshot.model_copy(update={"version": "0.0.1"}), None)


def test_files_without_a_snapshot_are_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "notes.txt").write_text("no snapshot")
    for name, words in (("notes.txt", "invalid snapshot: {}"), ("none", "cannot read {}: No such file")):
        arguments = [
            "mujoco",
            "--from-snapshot",
            str(tmp_path / name),
            "--listen",
            f"unixsock-stream/{tmp_path}/hub",
        ]
        assert main(arguments) == INVALID
        assert f"error: {words.format(tmp_path / name)}" in capsys.readouterr().err


@pytest.mark.more
def test_a_node_prints_the_time_of_its_snapshot(tmp_path: Path) -> None:
    file = tmp_path / "half.snapshot"
    file.write_bytes(wire.encode(save(driving())))
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    process = start("--listen", endpoint, "--from-snapshot", str(file), "--rate", "2")
    try:
        assert process.stdout is not None
        line = process.stdout.readline().decode()
        assert line == f"sim listens on {endpoint} with the world empty at 0.50 s; press Ctrl-C to stop\n"
        process.send_signal(signal.SIGINT)
        assert process.wait(30.0) == 0
    finally:
        process.kill()
        process.communicate()

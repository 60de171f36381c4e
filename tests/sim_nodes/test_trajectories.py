from __future__ import annotations

import csv
import io
from importlib.util import find_spec

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import GET_ARTIFACTS, Empty
from sim_nodes.trajectories import SAMPLE_TICKS, Samples
from sim_nodes.trajectory_files import trajectory_files
from tests.sim_nodes.client import ROBOT, Client, pose


def table(client: Client, name: str = "trajectories.csv") -> bytes:
    simulation = client.simulator.simulation
    files = trajectory_files(simulation.run_data.trajectories, simulation.time_of_tick)
    return next(each.data for each in files if each.name == name)


def rows(data: bytes, entity: str, key: str = "entity") -> list[dict[str, str]]:
    return [row for row in csv.DictReader(io.StringIO(data.decode())) if row[key] == entity]


def drive(client: Client, linear: float, duration: float) -> None:
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=linear, angular=0.0, duration=duration))


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_poses_commands_and_contacts_are_recorded(engine: str) -> None:
    client = Client("empty", engine=engine)
    client.localise(pose(0.0, 0.1))  # 10 cm beside the truth
    client.spawn("box", pose(0.6, 0.0, z=0.1))
    drive(client, 0.3, 2.5)
    client.run_until("drive")
    data = table(client)
    robot = rows(data, ROBOT)
    assert [float(row["time"]) for row in robot] == [pytest.approx(0.1 * i) for i in range(len(robot))]
    assert len(robot) in (25, 26)
    last, truth = robot[-1], client.truth
    assert float(last["x"]) == pytest.approx(truth.x, abs=0.04)
    assert float(last["believed_y"]) - float(last["y"]) == pytest.approx(0.1, abs=0.05)
    assert float(last["odom_x"]) == pytest.approx(truth.x, abs=0.15)
    assert max(float(row["command_linear"]) for row in robot) == pytest.approx(0.3)
    touched = [float(row["x"]) for row in robot if row["contact"] == "1"]
    assert touched and min(touched) > 0.25
    box = rows(data, "box")
    assert {row["contact"] for row in box} == {"0", "1"}
    assert {row["believed_x"] for row in box} == {""}
    assert float(box[-1]["x"]) > 0.6


def test_the_joints_of_arms_are_recorded() -> None:
    client = Client("arm_cell")
    robot = next(iter(client.simulator.simulation.robots))
    client.advance(1.0)
    states = client.simulator.simulation.robot(robot).arm.states().positions
    found = rows(table(client, "joint_trajectories.csv"), robot, "robot")
    assert [float(row["position"]) for row in found[-len(states) :]] == pytest.approx(states.tolist(), abs=1e-5)
    assert (found[0]["time"], found[-1]["time"]) == ("0.0", "1.0")
    assert rows(table(client), robot)[0]["believed_x"] == ""
    names = [each.name for each in client.ask(GET_ARTIFACTS, Empty()).artifacts]
    assert names[-2:] == ["trajectories.csv", "joint_trajectories.csv"]


def test_trajectories_do_not_depend_on_grants_lookahead_and_snapshots() -> None:
    def started() -> Client:
        client = Client("empty", 3)
        client.spawn("box", pose(1.0, 0.5, z=0.4))  # it falls while the robot rests
        client.advance(1.3)
        drive(client, 0.3, 1.0)
        return client

    plain = started()
    plain.run_until("drive")
    plain.advance(4.0)
    ahead = started()
    for until in (1.37, 1.9, 2.3, 2.3, 2.45, 4.0):
        ahead.ask(wire.ADVANCE, wire.Advance(until=until, horizon=until + 0.7))
        ahead.ask(wire.REWIND, wire.Rewind(time=until))
    begun = started()
    begun.advance(2.0)
    snapshot = begun.ask(wire.SAVE_STATE, Empty())
    begun.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot, purpose=wire.Purpose.CONTINUE))
    begun.run_until("drive")
    begun.advance(4.0)
    assert table(plain) == table(ahead) == table(begun)
    resting = [row["time"] for row in rows(table(plain), ROBOT) if float(row["time"]) < 1.3]
    assert resting == ["0.0", "1.0"]


def test_a_full_table_drops_every_second_sample() -> None:
    samples = Samples(1, limit=512)
    ticks = range(0, 1000 * SAMPLE_TICKS, SAMPLE_TICKS)
    for tick in ticks:
        for name in ("a", "b"):
            if samples.is_due(tick):
                samples.add(tick, name, (float(tick),))
    found = list(samples.rows())
    assert len(found) == len(samples) <= 512
    assert [tick for tick, name, _ in found if name == "b"] == list(range(0, ticks[-1] + 1, 4 * SAMPLE_TICKS))
    assert all(values == [float(tick)] for tick, _, values in found)


@pytest.mark.skipif(find_spec("pyarrow") is None, reason="pyarrow is not installed")
def test_tables_are_equal_as_parquet() -> None:
    from pyarrow import parquet

    from seoro.embed.parquet import to_parquet

    client = Client("empty")
    client.spawn("box", pose(1.0, 0.5, z=0.1))
    client.advance(0.2)
    data = table(client)
    read = parquet.read_table(io.BytesIO(to_parquet(data))).to_pylist()
    written = list(csv.DictReader(io.StringIO(data.decode())))
    assert [str(row["x"]) for row in read] == [row["x"] for row in written]
    assert [row["entity"] for row in read] == [row["entity"] for row in written]
    assert {row["believed_x"] for row in read} == {None}
    assert {type(row["contact"]) for row in read} == {int}

"""Samples of poses in the answers to grants."""

from __future__ import annotations

import struct
from itertools import pairwise

import pytest

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes import snapshots as going_ahead
from sim_nodes import tracks
from sim_nodes.__main__ import ENGINES
from tests.sim_nodes.client import BOX, ROBOT, Client, pose
from tests.sim_nodes.graph import differences

on_both = pytest.mark.parametrize("engine", ENGINES)


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(going_ahead, "LONGEST", 60.0)  # [s]


def start(client: Client, rate: float = 10.0, scans: float = 0.0) -> None:
    client.ask(wire.START_TRACKS, wire.StartTracks(rate=rate, scans=scans))


def rows(samples: tuple[wire.TrackSample, ...] | list[wire.TrackSample], name: str) -> list[tuple[float, ...]]:
    """Return the time and the numbers of each sample of an entity."""
    found = []
    for sample in samples:
        if name in sample.entities:
            at = tracks.POSE.size * sample.entities.index(name)
            found.append((sample.time, *tracks.POSE.unpack_from(sample.poses, at)))
    return found


def drive(client: Client, duration: float) -> None:
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.3, angular=0.2, duration=duration))


@on_both
def test_moving_entities_are_sampled_at_the_rate(engine: str) -> None:
    client = Client("empty", engine=engine)
    client.localise()
    client.spawn("box", pose(3.0, 3.0, z=0.1))
    start(client)
    drive(client, 1.0)
    samples = client.advance(5.0).tracks + client.advance(5.0).tracks
    robot, truth = rows(samples, ROBOT), client.truth
    assert [row[0] for row in robot[:12]] == pytest.approx([0.1 * index for index in range(12)])
    last = robot[-1]
    assert last[1:3] == pytest.approx((truth.x, truth.y), abs=1e-4)
    assert max(row[8] for row in robot) == pytest.approx(0.3, abs=0.05)  # velocity along x
    assert max(row[13] for row in robot) == pytest.approx(0.2, abs=0.05)  # turn rate
    assert all(round(value, 4) == value for row in robot for value in row[1:])
    believed = [sample for sample in samples if ROBOT in sample.localised]
    assert len(believed[-1].believed) == tracks.BELIEVED.size
    assert len(rows(samples, "box")) < 10  # at rest after it has settled


def test_a_body_that_falls_beside_idle_robots_is_sampled() -> None:
    client = Client("empty")
    client.spawn("box", pose(1.0, 0.5, z=2.0))
    start(client, 50.0)
    heights = [row[3] for row in rows(client.advance(0.4).tracks, "box")]
    assert len(heights) == 21
    assert heights == sorted(heights, reverse=True)


def test_spawned_bodies_and_other_worlds_are_described() -> None:
    client = Client("empty")
    start(client)
    client.advance(0.5)
    client.spawn("box", pose(1.0, 0.5, z=0.2))
    client.advance(1.0)
    client.ask(wire.CHANGE_WORLD, wire.ChangeWorld(world="maze", robots={}))
    samples = client.advance(1.5).tracks
    [scene] = [sample.scene for sample in samples if sample.scene is not None]
    assert (scene.world, scene.time) == ("maze", 1.0)
    assert not any(sample.added for sample in samples)
    client.spawn("ball", pose(0.5, 0.0, z=0.3), BOX)
    [added] = [sample.added for sample in client.advance(2.0).tracks if sample.added]
    assert [(each.name, each.kind, len(each.shapes)) for each in added] == [("ball", "object", 1)]


@on_both
def test_scans_have_the_faults_of_their_lidar(engine: str) -> None:
    client = Client("maze", engine=engine)
    client.localise()
    start(client, scans=5.0)
    scans = [(sample.time, scan) for sample in client.advance(1.0).tracks for scan in sample.scans]
    assert [time for time, _ in scans] == pytest.approx([0.2 * index for index in range(len(scans))], abs=0.11)
    assert len(scans) >= 5
    loss = wire.InjectFault(id="fault", robot=ROBOT, device="lidar", fault=wire.PowerLoss(), limit=5.0)
    client.ask(wire.INJECT_FAULT, loss)
    assert not [scan for sample in client.advance(3.0).tracks[2:] for scan in sample.scans]


def test_invalid_rates_of_scans_are_refused() -> None:
    client = Client("empty")
    with pytest.raises(RequestRefused, match=r"invalid rate 20.0 of scans: expected 0 to 10 Hz"):
        start(client, scans=20.0)


def test_deleted_bodies_are_named_once() -> None:
    client = Client("empty")
    client.spawn("box", pose(1.0, 0.5, z=0.2))
    start(client)
    client.advance(0.5)
    client.ask(wire.DELETE_ENTITY, wire.EntityName(name="box"))
    samples = client.advance(1.5).tracks
    assert [sample.removed for sample in samples if sample.removed] == [("box",)]


@on_both
def test_sampling_does_not_change_the_simulation(engine: str) -> None:
    one, other = (Client("maze", 3, engine) for _ in range(2))
    start(other, 50.0 / 3)
    for client in (one, other):
        client.advance(1.7)
        client.localise()
        client.spawn("box", pose(1.9, 0.6, z=0.4))
        client.navigate(pose(1.5, 1.5))
        client.advance(3.0)
    assert differences(one.simulator.simulation, other.simulator.simulation) == []


@on_both
def test_lookahead_and_rewinding_do_not_change_samples(engine: str) -> None:
    def begun() -> Client:
        client = Client("maze", 3, engine)
        client.spawn("box", pose(1.0, 0.5, z=0.4))
        client.localise()
        start(client, scans=3.0)
        client.navigate(pose(1.5, 1.5))
        return client

    plain, found = begun(), list[wire.TrackSample]()
    while plain.simulator.time < 2.0:
        found += plain.advance(2.0).tracks
    ahead, seen = begun(), list[wire.TrackSample]()
    for until in (0.13, 0.5, 0.78, 1.3, 2.0):
        while ahead.simulator.time < until:
            advanced = ahead.ask(wire.ADVANCE, wire.Advance(until=until, horizon=until + 0.7))
            ahead.ask(wire.REWIND, wire.Rewind(time=until))
            seen += [sample for sample in advanced.tracks if sample.time <= ahead.simulator.time]
    assert len(found) > 15
    assert seen == found
    assert len([scan for sample in found for scan in sample.scans]) >= 5
    plans = [(sample.time, plan) for sample in found for plan in sample.plans]
    assert [plan.robot for _, plan in plans][:1] == [ROBOT]
    assert all(later[0] - before[0] >= 1.0 for before, later in pairwise(plans))
    x, y = struct.unpack_from("<2d", plans[0][1].points, len(plans[0][1].points) - 16)
    assert (x, y) == pytest.approx((1.5, 1.5), abs=0.1)


def test_all_entities_are_sampled_after_a_change() -> None:
    client = Client("empty")
    start(client)
    client.advance(1.0)
    snapshot = client.ask(wire.SAVE_STATE, wire.Empty())
    client.advance(2.0)
    client.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot, purpose=wire.Purpose.REWIND))
    first, *_ = client.advance(3.0).tracks
    assert (first.time, first.entities) == (2.0, (ROBOT,))


def test_the_next_run_has_no_samples_of_the_one_before() -> None:
    client = Client("empty")
    start(client)
    client.advance(1.0)
    client.ask(wire.LOAD_WORLD, wire.LoadWorld(world=""))
    drive(client, 1.0)
    assert client.advance(1.0).tracks == ()


def test_samples_that_no_grant_takes_are_bounded(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tracks, "MAX_WAITING", 2000)
    client = Client("empty")
    drive(client, 9.0)
    start(client)
    client.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=1000))
    advanced = client.advance(client.simulator.time)
    assert len(advanced.tracks) + advanced.dropped_samples == 41
    assert advanced.dropped_samples > 30


@pytest.mark.parametrize("rate", [-1.0, 51.0, float("nan")])
def test_invalid_rates_are_refused(rate: float) -> None:
    with pytest.raises(RequestRefused, match="expected 0 to 50 Hz"):
        start(Client("empty"), rate)

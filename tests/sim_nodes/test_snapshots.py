from __future__ import annotations

import zlib
from collections.abc import Iterator
from dataclasses import replace
from hashlib import blake2b

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Delay, Fault, GaussianNoise, MessageLoss, Purpose, Quantity, WheelSlip
from seoro.bridges.wire.refusal import RequestRefused
from seoro.robotics.measures import Measure, MeasureLimit
from sim_nodes import snapshots
from sim_nodes.__main__ import ENGINES
from sim_nodes.codec import pack
from sim_nodes.robots.mobile import MobileBase
from sim_nodes.sensors.base import Odometry
from sim_nodes.sensors.lidar import Lidar
from sim_nodes.worlds.loader import load_world
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.graph import differences

GOAL = pose(1.5, 1.5)
AHEAD = pose(1.9, 0.6, z=0.05)
Seen = list[object]


def inject(client: Client, name: str, device: str, fault: Fault) -> None:
    request = wire.InjectFault(id=name, robot=ROBOT, device=device, fault=fault, limit=100.0)
    client.ask(wire.INJECT_FAULT, request)


def busy(engine: str, seed: int = 3) -> Client:
    """Return a client of a driving robot with watches, faults, a box ahead, and one that falls on it."""
    client = Client("maze", seed, engine)
    client.localise()
    client.navigate(GOAL)
    client.watch(5.0, 5.0, 0.1, watch="far")
    client.ask(wire.WATCH_BUMPER, wire.WatchBumper(id="bump", robot=ROBOT))
    client.ask(
        wire.CHECK_RATE,
        wire.CheckRate(id="rate", robot=ROBOT, sensor="imu", lowest=0.0, highest=100.0, duration=8.0),
    )
    client.ask(wire.WATCH_DISTANCE, wire.WatchDistance(id="way", robot=ROBOT, distance=1.1))
    limit = MeasureLimit(Measure.PATH_LENGTH, 1.2, above=True)
    client.ask(wire.WATCH_MEASURE, wire.WatchMeasure(id="path", entity=ROBOT, limit=limit))
    client.spawn("box", AHEAD)
    for name, at in (("guest", pose(-2.0, 0.0)), ("left", pose(-1.0, 1.0))):
        client.ask(wire.SPAWN_PERSON, wire.SpawnPerson(name=name, pose=at))
    low, high = wire.Position3D(-3.0, -3.0), wire.Position3D(0.0, 3.0)
    client.ask(wire.WANDER, wire.Wander(id="wander", person="guest", lower=low, upper=high))
    client.ask(wire.DELETE_ENTITY, wire.EntityName(name="left"))
    client.spawn("gone", pose(-1.0, -1.0, z=0.3))
    inject(client, "late", "lidar", Delay(time=0.06))
    inject(client, "lost", "lidar", MessageLoss(probability=0.02))
    client.advance(0.1)
    client.run_until("late")
    while client.simulator.simulation.time < 1.5:
        client.advance(1.5)
    inject(client, "slips", "motors", WheelSlip(left=0.1, right=0.1))
    inject(client, "jerks", "motors", GaussianNoise(deviation={Quantity.ANGULAR_RATE: 0.1}))
    inject(client, "slow", "motors", Delay(time=0.1))
    inject(client, "noisy", "odometry", GaussianNoise(deviation={Quantity.LENGTH: 0.002}))
    client.ask(wire.DELETE_ENTITY, wire.EntityName(name="gone"))
    client.spawn("falling", pose(client.truth.x, client.truth.y, z=0.5))
    time = 1.5
    while time < 2.51:  # during a tick, and between two scans
        time = client.advance(2.51).time
    return client


@pytest.mark.parametrize("purpose", [Purpose.CONTINUE, Purpose.BEGIN])
def test_a_restored_robot_keeps_its_velocity_command(purpose: Purpose) -> None:
    original = Client("empty", 3)
    original.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.2, angular=0.3, duration=2.0))
    original.advance(0.3)
    snapshot = save(original)
    ended, _ = original.run_until("drive")
    fork = Client("maze", 99)
    restore(fork, snapshot, purpose)
    if purpose is Purpose.CONTINUE:
        assert fork.run_until("drive") == (ended, [])
    else:
        assert fork.advance(ended.time - 0.3).occurrences == ()
    assert (fork.truth, fork.simulator.simulation.robot(ROBOT).mobile.odometry.pose) == (
        original.truth,
        original.simulator.simulation.robot(ROBOT).mobile.odometry.pose,
    )


def save(client: Client) -> wire.Snapshot:
    answer = client.ask(wire.SAVE_STATE, wire.Empty())
    return wire.SAVE_STATE.read_reply(wire.encode(answer))


def restore(
    client: Client, snapshot: wire.Snapshot, purpose: Purpose = Purpose.CONTINUE, seed: int | None = None
) -> wire.SimulatorFeatures:
    return client.ask(wire.RESTORE_STATE, wire.RestoreState(snapshot=snapshot, purpose=purpose, seed=seed))


def follow(client: Client, until: float) -> Iterator[object]:
    """Return all later observations of a run: answers, states, samples and localised poses."""
    time = client.simulator.simulation.time
    while time < until:
        advanced = client.advance(min(until, time + 0.25))
        time = advanced.time
        yield wire.encode(advanced)
        yield client.estimate
        scan = client.simulator.simulation.robot(ROBOT).mobile._scan
        yield scan and scan.ranges.tobytes()
        for name in client.ask(wire.GET_ENTITIES, wire.EntityFilter()).names:
            yield client.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=name))


@pytest.mark.parametrize("engine", ["mujoco", pytest.param("pybullet", marks=pytest.mark.slow)])
def test_a_fork_continues_bit_identically(engine: str) -> None:
    original = busy(engine)
    snapshot = save(original)
    rest = list(follow(original, 7.0))
    assert any(b"way" in seen for seen in rest if isinstance(seen, bytes))
    fork = Client("empty", 99, engine)
    features = restore(fork, snapshot)
    assert (features.world, features.time, features.state) == ("maze", snapshot.time, wire.SimulationState.PAUSED)
    assert list(follow(fork, 7.0)) == rest
    restore(original, snapshot)
    assert list(follow(original, 7.0)) == rest


@pytest.mark.parametrize("engine", ENGINES)
def test_snapshots_contain_all_state(engine: str) -> None:
    original = busy(engine)
    fork = Client("empty", 99, engine)
    restore(fork, save(original))
    assert differences(original.simulator.simulation, fork.simulator.simulation) == []


def test_undeclared_state_is_detected(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(Odometry, "STATE", ("_angles",))
    monkeypatch.setattr(MobileBase, "STATE", ("sensors", "localisation", "navigator", "_scan"))
    original = busy("mujoco")
    fork = Client("empty", 99, "mujoco")
    restore(fork, save(original))
    found = "\n".join(differences(original.simulator.simulation, fork.simulator.simulation))
    assert "['_now'][1]" in found
    assert "['obstacles']" in found


@pytest.mark.more
def test_another_seed_changes_a_restored_run() -> None:
    snapshot = save(busy("mujoco"))
    rests = []
    for seed in (None, 3, 4):
        fork = Client("empty", 99, "mujoco")
        restore(fork, snapshot, seed=seed)
        rests.append(list(follow(fork, 4.0)))
    assert rests[0] == rests[1] != rests[2]


@pytest.mark.slow
def test_a_run_from_a_snapshot_continues_motions_of_robots() -> None:
    original = busy("mujoco")
    snapshot = save(original)
    left = snapshot.time
    ended, _ = original.run_until("goal")
    fork = Client("empty", 99, "mujoco")
    restore(fork, snapshot, Purpose.BEGIN)
    assert fork.simulator.simulation.time == 0.0
    fork.navigate(GOAL, goal="mine")
    again, _ = fork.run_until("mine")
    assert again.time == pytest.approx(ended.time - left, abs=1e-9)
    assert (fork.truth, fork.estimate) == (original.truth, original.estimate)


@pytest.mark.slow
def test_a_run_from_a_snapshot_gets_no_events_of_another_run() -> None:
    snapshot = save(busy("mujoco"))
    fork = Client("empty", 99, "mujoco")
    restore(fork, snapshot, Purpose.BEGIN)
    time = 0.0
    reported: list[wire.Occurrence] = []
    while time < 20.0:
        advanced = fork.advance(20.0)
        time = advanced.time
        reported += advanced.occurrences
    assert reported == []
    assert fork.truth.distance(GOAL.position.x, GOAL.position.y) < 0.2  # it continued without a client
    with pytest.raises(RequestRefused, match="no active goal"):
        fork.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="goal"))


@pytest.mark.slow
def test_a_goal_replaces_a_goal_without_a_client() -> None:
    fork = Client("empty", 99, "mujoco")
    restore(fork, save(busy("mujoco")), Purpose.BEGIN)
    fork.navigate(pose(0.5, 0.0), goal="mine")
    ended, _ = fork.run_until("mine")
    assert ended.outcome is wire.Outcome.SUCCEEDED
    assert fork.truth.distance(0.5, 0.0) < 0.2


def test_rewinding_keeps_the_clock_and_cancels_later_goals() -> None:
    client = Client("maze", 3)
    client.localise()
    client.watch(5.0, 5.0, 0.1, watch="before")
    client.advance(1.0)
    snapshot = save(client)
    client.navigate(GOAL, goal="since")
    client.watch(-5.0, -5.0, 0.1, watch="after")
    client.spawn("box", AHEAD)
    client.advance(3.0)
    features = restore(client, snapshot, Purpose.REWIND)
    assert features.time == 3.0
    assert client.truth.distance(0.0, 0.0) < 0.01
    assert "box" not in client.ask(wire.GET_ENTITIES, wire.EntityFilter()).names
    advanced = client.advance(3.5)
    assert [(each.id, each.outcome) for each in advanced.occurrences] == [("since", wire.Outcome.CANCELED)]
    for watch in ("before", "after"):
        client.ask(wire.CANCEL_WATCH, wire.CancelWatch(id=watch))


def test_rewinding_continues_a_goal_that_is_active_in_both_states() -> None:
    client = Client("maze", 3)
    client.localise()
    client.navigate(GOAL)
    client.ask(wire.WATCH_DISTANCE, wire.WatchDistance(id="way", robot=ROBOT, distance=1.0))
    client.advance(2.0)
    snapshot = save(client)
    client.advance(3.0)
    client.ask(wire.WATCH_DISTANCE, wire.WatchDistance(id="late", robot=ROBOT, distance=0.2))
    travelled = client.simulator.simulation.travelled(ROBOT)
    restore(client, snapshot, Purpose.REWIND)
    assert client.simulator.simulation.travelled(ROBOT) < travelled
    late, _ = client.run_until("late")
    way, _ = client.run_until("way")
    ended, _ = client.run_until("goal")
    assert late.time < way.time < ended.time
    assert ended.outcome is wire.Outcome.SUCCEEDED


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"engine": "pybullet"}, "the engine pybullet; found mujoco"),
        ({"engine_version": "3.0"}, "version of mujoco 3.0"),
        ({"version": "9.9"}, "version of seoro 9.9"),
        ({"format": 7}, "the format 7; found 3"),
        ({"state": b"nonsense"}, "damaged"),
    ],
    ids=str,
)
def test_a_snapshot_of_another_engine_or_version_is_refused(
    empty: Client, change: dict[str, object], words: str
) -> None:
    before = save(empty)
    with pytest.raises(RequestRefused, match=words):
        restore(empty, before.model_copy(update=change))
    assert save(empty) == before


def test_a_mismatched_snapshot_changes_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    client = busy("mujoco")
    other = busy("mujoco")
    with monkeypatch.context() as patched:
        patched.setattr(Lidar, "STATE", ("period",))
        snapshot = save(client)
    with pytest.raises(RequestRefused, match="cannot restore the snapshot: found a Lidar; "):
        restore(other, snapshot)
    assert list(follow(other, 4.0)) == list(follow(client, 4.0))


def test_a_forged_snapshot_is_refused_and_changes_nothing(empty: Client) -> None:
    snapshot = save(empty)
    contents = snapshots.check(snapshot, empty.simulator.simulation.engine)
    walls = (replace(wall, height=-1.0) for wall in load_world("maze").walls)
    made_up = replace(contents, world=replace(contents.world, walls=tuple(walls)))
    state = zlib.compress(pack(made_up))
    digest = blake2b(state, digest_size=16).hexdigest()
    with pytest.raises(RequestRefused, match="cannot restore"):
        restore(empty, snapshot.model_copy(update={"state": state, "digest": digest}))
    assert empty.advance(0.5).time == 0.5
    assert empty.truth.distance(0.0, 0.0) < 0.01


def test_diverged_physics_cannot_be_saved_and_can_be_restored(empty: Client) -> None:
    snapshot = save(empty)
    empty.simulator.simulation.engine._data.qpos[:] = float("nan")  # type: ignore[attr-defined]
    with pytest.raises(RequestRefused, match="reset the simulation"):
        empty.advance(0.1)
    with pytest.raises(RequestRefused, match="cannot save the state: the physics has diverged"):
        save(empty)
    restore(empty, snapshot)
    assert empty.advance(1.0).time == 1.0
    assert empty.truth.distance(0.0, 0.0) < 0.01

"""Simulating ahead and rewinding does not change results."""

from __future__ import annotations

import random
from operator import attrgetter

import pytest

from seoro.bridges import wire
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes import snapshots as going_ahead
from sim_nodes.__main__ import ENGINES
from sim_nodes.codec import pack
from sim_nodes.physics import SavesState
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.engines import PYBULLET_IN_MORE, make_engine
from tests.sim_nodes.graph import differences
from tests.sim_nodes.manipulation.cell import ARM, HOME

on_both = pytest.mark.parametrize("engine", ENGINES)

END = 4.0  # [s]
AWAY = (HOME[0] + 0.3, *HOME[1:])  # [rad]


@pytest.fixture(autouse=True)
def patience(monkeypatch: pytest.MonkeyPatch) -> None:
    """Make results independent of the load of the machine."""
    monkeypatch.setattr(going_ahead, "LONGEST", 60.0)  # [s]


def ahead(client: Client, until: float, horizon: float, *, collects_feedback: bool = False) -> wire.Advanced:
    grant = wire.Advance(until=until, horizon=horizon, collects_feedback=collects_feedback)
    return client.ask(wire.ADVANCE, grant)


def rewind(client: Client, time: float) -> float:
    return client.ask(wire.REWIND, wire.Rewind(time=time)).time


def busy(engine: str) -> Client:
    """Return a client of a driving robot with a noisy lidar, beside a box that falls onto another."""
    client = Client("maze", 3, engine)
    client.localise()
    client.navigate(pose(1.5, 1.5), feedback_period=0.3)
    client.ask(wire.WATCH_DISTANCE, wire.WatchDistance(id="way", robot=ROBOT, distance=0.4))
    client.ask(wire.SPAWN_PERSON, wire.SpawnPerson(name="guest", pose=pose(-2.0, 0.0)))
    low, high = wire.Position3D(-3.0, -3.0), wire.Position3D(0.0, 3.0)
    client.ask(wire.WANDER, wire.Wander(id="wander", person="guest", lower=low, upper=high))
    client.spawn("low", pose(1.9, 0.6))
    client.spawn("high", pose(1.9, 0.6, z=0.8))
    fault = wire.GaussianNoise(deviation={wire.Quantity.LENGTH: 0.05})
    client.ask(
        wire.INJECT_FAULT, wire.InjectFault(id="noise", robot=ROBOT, device="lidar", fault=fault, limit=9.0)
    )
    return client


def plain(client: Client, until: float) -> list[object]:
    """Return the events up to a time, in grants of 20 ms."""
    seen: list[object] = []
    while client.simulator.time < until:
        advanced = client.advance(min(until, client.simulator.time + 0.02))
        seen += [*advanced.contacts, *advanced.occurrences, *advanced.feedback]
    return seen


def there_and_back(client: Client, until: float, draw: random.Random) -> list[object]:
    """Return the events for a client that announces a horizon and rewinds half of it."""
    seen: list[object] = []
    while (now := client.simulator.time) < until:
        grant = min(until, round(now + 0.02, 9))
        horizon = min(until, now + draw.choice((0.1, 0.5, 2.0)))
        advanced = ahead(client, grant, horizon, collects_feedback=draw.random() < 0.5)
        if advanced.time > grant and draw.random() < 0.7:
            back = draw.uniform(grant, advanced.time)
            assert back <= rewind(client, back) < back + 0.005
            seen += [each for each in advanced.feedback if each.time <= back]
            continue
        events = [*advanced.contacts, *advanced.occurrences, *advanced.feedback]
        seen += sorted(events, key=attrgetter("time"))
    return seen


def kept(client: Client) -> bytes:
    engine = client.simulator.simulation.engine
    assert isinstance(engine, SavesState)
    return pack(engine.save())


@pytest.mark.parametrize("engine", PYBULLET_IN_MORE)
@pytest.mark.parametrize("seed", [0, *(pytest.param(seed, marks=pytest.mark.slow) for seed in (1, 2))])
def test_rewinding_leaves_no_trace(seed: int, engine: str) -> None:
    one, other = busy(engine), busy(engine)
    happened = plain(one, END)
    assert there_and_back(other, END, random.Random(seed)) == happened
    assert {"noise", "way"} <= {each.id for each in happened if isinstance(each, wire.Occurrence)}
    assert any(isinstance(each, wire.Contact) for each in happened)
    assert any(isinstance(each, wire.NavigationFeedback) for each in happened)
    assert differences(one.simulator.simulation, other.simulator.simulation) == []
    assert kept(one) == kept(other)


@on_both
def test_a_rewound_arm_continues_identically(engine: str) -> None:
    ends = []
    for tried in (False, True):
        client = Client("arm_cell", engine=engine)
        goal = wire.FollowJointTrajectory(id="goal", robot=ARM, points=(AWAY,))
        client.ask(wire.FOLLOW_JOINT_TRAJECTORY, goal)
        client.advance(0.3)
        if tried:
            ahead(client, 0.32, 0.9)
            assert rewind(client, 0.4) == pytest.approx(0.4)
        ended, _ = client.run_until("goal")
        ends.append((ended, client.simulator.simulation.engine.joint_states(ARM).positions.tobytes()))
    assert ends[0] == ends[1]


@on_both
def test_a_node_simulates_ahead_to_the_first_event(engine: str) -> None:
    client = Client("maze", engine=engine)
    client.spawn("box", pose(0.45, 0.0, z=0.1))
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.3, angular=0.0, duration=4.0))
    advanced = ahead(client, 0.02, 4.0)
    assert [each.second for each in advanced.contacts] == [ROBOT]
    assert 0.02 < advanced.time < 4.0
    assert rewind(client, 0.1) == pytest.approx(0.1)
    assert client.advance(4.0).contacts == advanced.contacts


@on_both
def test_feedback_ends_it_only_for_clients_that_do_not_collect_it(engine: str) -> None:
    client = Client("maze", engine=engine)
    client.localise()
    client.navigate(pose(1.5, 1.5), feedback_period=0.5)
    assert [each.time for each in ahead(client, 0.5, 2.2).feedback] == [pytest.approx(0.5)]
    assert rewind(client, 0.5) == pytest.approx(0.5)
    advanced = ahead(client, 1.0, 2.2, collects_feedback=True)
    assert advanced.time == pytest.approx(2.2)
    assert [each.time for each in advanced.feedback] == pytest.approx([1.0, 1.5, 2.0])
    assert rewind(client, 1.5) == pytest.approx(1.5)
    assert client.advance(2.2).feedback == advanced.feedback[2:]


@pytest.mark.engine("mujoco")
def test_another_request_discards_the_checkpoint() -> None:
    client = Client("maze")
    reached = ahead(client, 0.02, 1.0).time
    client.ask(wire.STOP_ROBOT, wire.StopRobot(robot=ROBOT))
    assert rewind(client, 0.02) == reached


@on_both
def test_questions_of_viewers_leave_the_checkpoint(engine: str) -> None:
    """Others may ask while the simulator is ahead of its run, such as pages that show a lab."""
    ends = []
    for is_viewed in (False, True):
        client = busy(engine)
        reached = ahead(client, 0.02, 1.0).time
        if is_viewed:
            client.ask(wire.GET_ENTITIES_STATES, wire.EntityFilter())
            client.ask(wire.GET_LOCALIZATION, wire.RobotName(robot=ROBOT))
        assert rewind(client, 0.02) < reached
        ends.append((plain(client, 1.0), client.simulator.simulation))
    (happened, one), (seen, other) = ends
    assert happened == seen
    assert differences(one, other) == []


@pytest.mark.engine("mujoco")
@pytest.mark.parametrize("time", [0.1, 0.02, 0.0])
def test_rewinding_without_lookahead_changes_nothing(time: float) -> None:
    client = Client("maze")
    client.advance(0.5)
    assert rewind(client, time) == 0.5


@pytest.mark.engine("mujoco")
@pytest.mark.parametrize("horizon", [float("nan"), float("inf")])
def test_an_infinite_horizon_is_refused(horizon: float) -> None:
    with pytest.raises(RequestRefused, match="expected finite times"):
        ahead(Client("maze"), 0.02, horizon)


@pytest.mark.engine("mujoco")
def test_engines_without_rewinding_do_not_simulate_ahead(monkeypatch: pytest.MonkeyPatch) -> None:
    one_way = type("OneWay", (type(make_engine("mujoco")),), {"rewind": None})
    monkeypatch.setitem(ENGINES, "mujoco", one_way)
    client = Client("maze")
    features = client.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())
    assert wire.REWIND.name not in features.features
    assert ahead(client, 0.02, 1.0).time == pytest.approx(0.02)


@pytest.mark.engine("pybullet")
def test_without_a_checkpoint_nothing_is_simulated_ahead(monkeypatch: pytest.MonkeyPatch) -> None:
    client = Client("maze", engine="pybullet")
    monkeypatch.setattr(client.simulator.simulation.engine, "checkpoint", lambda: None)
    assert ahead(client, 0.02, 1.0).time == pytest.approx(0.02)
    assert rewind(client, 0.02) == pytest.approx(0.02)

from __future__ import annotations

import math

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome, ResetScope, Result, SimulationState, StateResult, WorldResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.pace import LAG
from tests.sim_nodes.client import BOX, ROBOT, TRUTH, Client, pose


def set_state(client: Client, state: SimulationState, rate: float = 1.0) -> None:
    client.ask(wire.SET_SIMULATION_STATE, wire.SetSimulationState(state=state, rate=rate))


def features(client: Client) -> wire.SimulatorFeatures:
    return client.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())


def test_a_grant_ends_at_the_first_step_not_before_its_time(empty: Client) -> None:
    assert empty.advance(0.3).time == 0.3
    assert empty.advance(0.3).time == 0.3
    assert empty.advance(0.1).time == 0.3
    assert empty.advance(0.301).time == 0.304
    sum_of_tenths = 0.1 + 0.7 + 0.1  # a little less than 0.9
    assert empty.advance(sum_of_tenths).time >= sum_of_tenths


def test_infinite_grants_are_refused(empty: Client) -> None:
    for until in (math.inf, math.nan):
        with pytest.raises(RequestRefused, match="finite"):
            empty.advance(until)


def test_a_grant_returns_early_when_a_watch_fires(empty: Client) -> None:
    empty.localise()
    empty.navigate(pose(2.0, 0.0))
    empty.watch(1.0, 0.0, 0.2)
    advanced = empty.advance(30.0)
    [near] = advanced.occurrences
    assert (near.id, near.time, near.outcome) == ("near", advanced.time, Outcome.SUCCEEDED)
    assert 0.185 < empty.truth.distance(1.0, 0.0) <= 0.2
    assert empty.advance(advanced.time + 0.1).occurrences == ()


def test_a_watch_that_is_true_already_is_reported_at_once(empty: Client) -> None:
    empty.watch(0.0, 0.0, 0.2)
    advanced = empty.advance(5.0)
    assert (advanced.time, [each.id for each in advanced.occurrences]) == (0.0, ["near"])


def test_a_watch_on_the_estimate_waits_for_an_initial_pose(empty: Client) -> None:
    empty.watch(2.0, 2.0, 0.2, frame="base_link")
    assert empty.advance(0.5).occurrences == ()
    empty.localise(pose(2.0, 2.0))
    assert [each.id for each in empty.advance(5.0).occurrences] == ["near"]


def test_a_watch_measures_in_the_parent_frame(empty: Client) -> None:
    empty.localise(pose(3.0, 0.0))
    request = wire.WatchProximity(
        id="odom", frame="base_link", parent_frame="odom", point=wire.Position3D(), threshold=0.1
    )
    empty.ask(wire.WATCH_PROXIMITY, request)
    assert [each.id for each in empty.advance(1.0).occurrences] == ["odom"]


def test_common_frame_names_refer_to_the_named_robot() -> None:
    hall = Client("hall")
    first, second = (robot.name for robot in hall.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty()).robots)
    hall.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot=second, pose=pose(0.0, -2.0, math.pi / 2.0)))
    for robot in (first, second):
        hall.ask(
            wire.WATCH_PROXIMITY,
            wire.WatchProximity(
                id=robot,
                frame="base_link",
                parent_frame="map",
                point=wire.Position3D(y=-2.0),
                threshold=0.1,
                robot=robot,
            ),
        )
    assert [each.id for each in hall.advance(1.0).occurrences] == [second]


def test_spawned_bodies_can_be_watched_until_deleted(empty: Client) -> None:
    empty.spawn("ball", pose(0.0, 3.0, z=0.5))
    empty.watch(2.0, 3.0, 0.2, frame="ball")
    assert empty.advance(0.5).occurrences == ()
    moved = wire.SetEntityState(name="ball", pose=pose(1.9, 3.0, z=0.5))
    empty.ask(wire.SET_ENTITY_STATE, moved)
    assert [each.id for each in empty.advance(1.0).occurrences] == ["near"]
    empty.watch(-2.0, 3.0, 0.2, frame="ball")
    empty.ask(wire.DELETE_ENTITY, wire.EntityName(name="ball"))
    assert empty.advance(1.5).occurrences == ()


def test_a_distance_is_counted_from_now(empty: Client) -> None:
    empty.localise()
    empty.navigate(pose(3.0, 0.0))
    empty.advance(4.0)
    before = empty.truth
    empty.ask(wire.WATCH_DISTANCE, wire.WatchDistance(id="far", robot=ROBOT, distance=0.5))
    empty.run_until("far")
    assert empty.truth.distance(before.x, before.y) == pytest.approx(0.5, abs=0.05)


def test_watches_can_be_canceled_and_invalid_ones_are_refused(empty: Client) -> None:
    empty.watch(5.0, 5.0, 0.2)
    with pytest.raises(RequestRefused, match="duplicate id 'near'"):
        empty.watch(5.0, 5.0, 0.2)
    empty.ask(wire.CANCEL_WATCH, wire.CancelWatch(id="near"))
    with pytest.raises(RequestRefused, match="unknown watch 'near'") as refused:
        empty.ask(wire.CANCEL_WATCH, wire.CancelWatch(id="near"))
    assert refused.value.code == Result.NOT_FOUND
    with pytest.raises(RequestRefused, match=f"unknown frame 'nose'; frames: .*{TRUTH}") as refused:
        empty.watch(0.0, 0.0, 0.2, frame="nose")
    assert refused.value.code == Result.NOT_FOUND
    with pytest.raises(RequestRefused, match="more than 0 m"):
        empty.watch(0.0, 0.0, -1.0)
    with pytest.raises(RequestRefused, match="point"):
        empty.watch(math.nan, 0.0, 1.0)


def test_a_contact_is_reported_once_when_it_begins(empty: Client) -> None:
    empty.spawn(
        "box", pose(0.8, 0.0), BOX.replace('<link name="link">', '<static>true</static><link name="link">')
    )
    empty.simulator.simulation.engine.command_wheels(ROBOT, 5.0, 5.0)
    contacts: list[wire.Contact] = []
    while (advanced := empty.advance(10.0)).time < 10.0:
        contacts += advanced.contacts
    [contact] = contacts
    assert (contact.first, contact.second) == ("box", ROBOT)
    assert contact.time == pytest.approx((0.8 - 0.15 - 0.164) / (5.0 * 0.03575), abs=0.3)


def test_touching_again_after_a_while_is_another_contact(empty: Client) -> None:
    empty.spawn("box", pose(0.4, 0.0))
    engine = empty.simulator.simulation.engine
    contacts: list[wire.Contact] = []
    for speed, until in ((4.0, 2.0), (-4.0, 4.0), (4.0, 8.0)):
        engine.command_wheels(ROBOT, speed, speed)
        while (advanced := empty.advance(until)).time < until:
            contacts += advanced.contacts
    assert len(contacts) == 2


def test_steps_are_made_while_paused_only(empty: Client) -> None:
    assert empty.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=25)).time == 0.1
    with pytest.raises(RequestRefused, match="expected 1 to"):
        empty.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=0))
    set_state(empty, SimulationState.PLAYING)
    with pytest.raises(RequestRefused, match="pause it first") as refused:
        empty.ask(wire.STEP_SIMULATION, wire.StepSimulation())
    assert refused.value.code == Result.INCORRECT_STATE
    with pytest.raises(RequestRefused, match="pause it first"):
        empty.advance(1.0)


def test_playing_follows_the_clock(empty: Client) -> None:
    simulator = empty.simulator
    assert simulator.keep_pace(100.0) is None
    set_state(empty, SimulationState.PLAYING)
    clock = 100.0
    while clock < 101.0:
        delay = simulator.keep_pace(clock)
        assert delay is not None
        clock += max(delay, 1e-3)
    assert simulator.simulation.time == pytest.approx(1.0, abs=0.05)
    before = simulator.simulation.time
    simulator.keep_pace(clock + LAG + 60.0)
    assert simulator.simulation.time < before + LAG, "missed time is not dropped"


@pytest.mark.parametrize("rate", [0.5, 3.0, 50.0])
def test_playing_may_be_slower_and_faster(empty: Client, rate: float) -> None:
    set_state(empty, SimulationState.PLAYING, rate)
    clock = 100.0
    while clock < 100.4:
        delay = empty.simulator.keep_pace(clock)
        assert delay is not None
        clock += max(delay, 1e-3)
    assert empty.simulator.simulation.time == pytest.approx(0.4 * rate, abs=max(0.05, 0.01 * rate))


def test_playing_as_fast_as_possible_does_not_wait(empty: Client) -> None:
    set_state(empty, SimulationState.PLAYING, math.inf)
    assert [empty.simulator.keep_pace(100.0) for _ in range(10)] == [0.0] * 10
    assert empty.simulator.simulation.time > 1.0


@pytest.mark.parametrize("rate", [0.0, -1.0, math.nan])
def test_an_invalid_rate_is_refused(empty: Client, rate: float) -> None:
    with pytest.raises(RequestRefused, match="invalid rate"):
        set_state(empty, SimulationState.PLAYING, rate)
    assert empty.simulator.state is SimulationState.STOPPED


def test_events_while_playing_are_pending_until_a_grant(empty: Client) -> None:
    empty.localise()
    empty.navigate(pose(2.0, 0.0))
    empty.watch(0.5, 0.0, 0.2)
    set_state(empty, SimulationState.PLAYING)
    clock = 0.0
    while empty.simulator.simulation.time < 3.0:
        empty.simulator.keep_pace(clock)
        clock += 0.02
    set_state(empty, SimulationState.PAUSED)
    advanced = empty.advance(4.0)
    assert [each.id for each in advanced.occurrences] == ["near"]
    assert advanced.time < 3.1


def test_states_change_as_in_simulation_interfaces(empty: Client) -> None:
    assert features(empty).state is SimulationState.STOPPED
    with pytest.raises(RequestRefused, match="already stopped") as refused:
        set_state(empty, SimulationState.STOPPED)
    assert refused.value.code == StateResult.ALREADY_IN_TARGET_STATE
    empty.advance(1.0)
    assert features(empty).state is SimulationState.PAUSED
    set_state(empty, SimulationState.STOPPED)
    assert (features(empty).state, features(empty).time) == (SimulationState.STOPPED, 0.0)


def busy(client: Client) -> None:
    client.localise()
    client.navigate(pose(2.0, 0.0))
    client.watch(5.0, 5.0, 0.2)
    client.spawn("box", pose(-2.0, -2.0))
    client.advance(2.0)


def reset(client: Client, scope: int) -> None:
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=scope))


def test_a_full_reset_starts_over(empty: Client) -> None:
    for scope in (ResetScope.DEFAULT, ResetScope.ALL):
        busy(empty)
        reset(empty, scope)
        assert features(empty).time == 0.0
        assert empty.truth == pytest.approx((0.0, 0.0, 0.0))
        assert empty.ask(wire.GET_ENTITIES, wire.EntityFilter()).names == (ROBOT,)
        assert empty.advance(0.5).occurrences == ()


def test_a_reset_covers_its_scope_only(empty: Client) -> None:
    busy(empty)
    reset(empty, ResetScope.TIME)
    assert features(empty).time == 0.0
    assert empty.truth.x > 0.2
    reset(empty, ResetScope.SPAWNED)
    assert empty.ask(wire.GET_ENTITIES, wire.EntityFilter()).names == (ROBOT,)
    assert empty.truth.x > 0.2
    empty.advance(1.0)
    reset(empty, ResetScope.STATE)
    assert empty.truth == pytest.approx((0.0, 0.0, 0.0))
    [ended] = empty.advance(2.0).occurrences
    assert (ended.id, ended.outcome, ended.time) == ("goal", Outcome.CANCELED, 1.0)
    with pytest.raises(RequestRefused, match="initial pose"):
        empty.navigate(pose(2.0, 0.0))
    with pytest.raises(RequestRefused, match="unknown reset scope 8"):
        reset(empty, 8)


def test_worlds_are_loaded_with_a_seed(empty: Client) -> None:
    empty.advance(1.0)
    loaded = empty.ask(wire.LOAD_WORLD, wire.LoadWorld(world="maze", seed=4))
    assert (loaded.world, loaded.time, loaded.state) == ("maze", 0.0, SimulationState.STOPPED)
    assert empty.simulator.simulation.seed == 4
    with pytest.raises(
        RequestRefused, match=r"unknown world 'moon' \(worlds: arm_cell, corridor, empty"
    ) as refused:
        empty.ask(wire.LOAD_WORLD, wire.LoadWorld(world="moon"))
    assert refused.value.code == WorldResult.NO_RESOURCE
    assert features(empty).world == "maze", "a world that cannot be loaded changes nothing"

"""Leases of robots: all or none, one client at a time, in the order of the wait queue."""

from __future__ import annotations

import random

import pytest

from seoro.bridges.leasing.event_filter import events_for
from seoro.bridges.leasing.leases import UNSEEN, Hold, Leases, describe_silence, expire
from seoro.bridges.wire.event_log import LoggedEvent, LoggedEvents, WorldChange
from seoro.bridges.wire.holds import HOLD_DEADLINE, HOLD_PATIENCE, QUEUE_PATIENCE, Holder
from seoro.bridges.wire.keys import public_holder_name
from seoro.bridges.wire.lab import LeaseRobots, ReleaseLease
from seoro.bridges.wire.refusal import RequestRefused
from seoro.bridges.wire.results import LabResult


class Clock:
    """A clock that a test sets."""

    def __init__(self) -> None:
        self.now = 100.0

    def __call__(self) -> float:
        return self.now


@pytest.fixture
def clock() -> Clock:
    return Clock()


@pytest.fixture
def leases(clock: Clock) -> Leases:
    return Leases(lambda: ("a", "b", "c"), clock)


def want(name: str, *robots: str, waits: bool = False, priority: int = 0, lease: str = "") -> Holder:
    return Holder(holder=name, purpose=f"run {name}", robots=robots, waits=waits, priority=priority, lease=lease)


def test_robots_are_acquired_all_or_none(leases: Leases) -> None:
    leases.acquire(want("one", "b"), 0.0)
    with pytest.raises(RequestRefused, match="'b' is held by run one: wait for its end") as refused:
        leases.acquire(want("two", "a", "b"), 0.0)
    assert refused.value.code == LabResult.HELD
    assert leases.holder_of("a") is None
    leases.acquire(want("two", "a", "c"), 0.0)
    leases.release("one")
    leases.acquire(want("three", "b"), 0.0)


def test_a_request_without_names_acquires_all_robots(leases: Leases) -> None:
    leases.acquire(want("one"), 0.0)
    with pytest.raises(RequestRefused, match="'a' is held by run one"):
        leases.acquire(want("two", "a"), 0.0)
    leases.release("one")
    leases.acquire(want("two", "a"), 0.0)
    with pytest.raises(RequestRefused, match="'a' is held by run two"):
        leases.acquire(want("one"), 0.0)


def test_an_unknown_robot_is_refused_with_its_name(leases: Leases) -> None:
    with pytest.raises(RequestRefused, match=r"unknown robot 'd' \(robots: a, b, c"):
        leases.acquire(want("one", "d"), 0.0)


def test_only_the_holder_may_move_a_robot(leases: Leases) -> None:
    leases.acquire(want("one", "a"), 0.0)
    leases.check("one", "a", has_to_hold=True)
    leases.check("", "b", has_to_hold=False)
    with pytest.raises(RequestRefused, match="the robot 'a' is held by run one"):
        leases.check("two", "a", has_to_hold=False)
    with pytest.raises(RequestRefused, match="the robot 'b' is not held"):
        leases.check("one", "b", has_to_hold=True)
    with pytest.raises(RequestRefused, match="only a are held"):
        leases.check_all("one")


def test_a_client_without_heartbeats_is_overdue_and_may_return(leases: Leases, clock: Clock) -> None:
    leases.acquire(want("one", "a"), 0.0)
    clock.now += HOLD_DEADLINE - 0.01
    leases.renew("one")
    clock.now += HOLD_DEADLINE
    (hold,) = leases.overdue()
    hold.is_alive = False
    assert leases.holder_of("a") is None
    leases.renew("one")
    assert leases.holder_of("a") is hold
    hold.is_alive = False
    assert leases.acquire(want("two", "a"), 0.0) == (hold,)
    with pytest.raises(RequestRefused, match="this run lost its robots: run two has them"):
        leases.renew("one")


def test_waiting_runs_acquire_robots_by_priority_and_arrival(leases: Leases) -> None:
    leases.acquire(want("one", "a"), 0.0)
    for name, priority in (("two", 0), ("three", 0), ("four", 1)):
        with pytest.raises(RequestRefused):
            leases.acquire(want(name, "a", waits=True, priority=priority), 0.0)
    assert leases.waiting_for("a") == ("run four", "run two", "run three")
    leases.release("one")
    with pytest.raises(RequestRefused, match="run four waits for 'a' already, and comes first"):
        leases.acquire(want("two", "a", waits=True), 0.0)
    with pytest.raises(RequestRefused, match="comes first"):
        leases.acquire(want("five", "a"), 0.0)
    leases.acquire(want("four", "a", waits=True, priority=1), 0.0)
    leases.release("four")
    leases.acquire(want("two", "a", waits=True), 0.0)


def test_a_waiting_run_with_more_robots_is_not_overtaken(leases: Leases) -> None:
    leases.acquire(want("one", "a"), 0.0)
    with pytest.raises(RequestRefused):
        leases.acquire(want("both", "a", "b", waits=True), 0.0)
    with pytest.raises(RequestRefused, match="run both waits"):
        leases.acquire(want("small", "b", waits=True), 0.0)


def test_a_silent_run_loses_its_place_in_the_queue(leases: Leases, clock: Clock) -> None:
    leases.acquire(want("one", "a"), 0.0)
    with pytest.raises(RequestRefused):
        leases.acquire(want("two", "a", waits=True), 0.0)
    leases.release("one")
    clock.now += QUEUE_PATIENCE
    leases.acquire(want("three", "a"), 0.0)


def test_a_run_that_stops_waiting_delays_no_other(leases: Leases) -> None:
    leases.acquire(want("one", "a"), 0.0)
    for waits in (True, False):
        with pytest.raises(RequestRefused):
            leases.acquire(want("two", "a", waits=waits), 0.0)
    leases.release("one")
    leases.acquire(want("three", "a"), 0.0)


def test_a_manual_lease_admits_only_runs_that_name_it(leases: Leases) -> None:
    leases.lease(LeaseRobots(lease="hand", robots=("a",), purpose="new wheels", duration=60.0))
    with pytest.raises(RequestRefused, match=r"'a' is leased until .* \(new wheels\)"):
        leases.acquire(want("one", "a"), 0.0)
    with pytest.raises(RequestRefused, match="leased until"):
        leases.check("", "a", has_to_hold=False)
    leases.acquire(want("one", "a", lease="hand"), 0.0)
    with pytest.raises(RequestRefused, match="held by run one"):
        leases.lease(LeaseRobots(lease="other", robots=("a",), duration=60.0))
    leases.release("one")
    leases.end_lease(ReleaseLease(robot="a"))
    leases.acquire(want("two", "a"), 0.0)
    with pytest.raises(RequestRefused, match="unknown lease of 'a'"):
        leases.end_lease(ReleaseLease(robot="a"))


def test_manual_leases_expire(leases: Leases, monkeypatch: pytest.MonkeyPatch) -> None:
    leases.lease(LeaseRobots(lease="hand", robots=("a",), duration=60.0))
    now = leases.lease_of("a")
    assert now is not None
    monkeypatch.setattr("time.time", lambda: now.until + 1.0)
    assert leases.lease_of("a") is None
    leases.acquire(want("one", "a"), 0.0)


@pytest.mark.parametrize("seed", range(20))
def test_all_clients_acquire_robots_of_several_nodes_eventually(seed: int) -> None:
    """Clients acquire robots of several nodes in one order, and release all after a refusal."""
    draw = random.Random(seed)
    clock = Clock()
    nodes = [Leases(lambda: ("a", "b"), clock) for _ in range(3)]
    wishes = {
        f"run{number}": {
            index: tuple(draw.sample(("a", "b"), draw.randint(1, 2)))
            for index in sorted(draw.sample(range(3), draw.randint(1, 3)))
        }
        for number in range(8)
    }
    holding: dict[str, int] = {}
    done: set[str] = set()
    for _ in range(2000):
        clock.now += 0.05
        for name in [name for name, until in holding.items() if draw.random() < 0.2 or until < 0]:
            for index in wishes[name]:
                nodes[index].release(name)
            del holding[name]
            done.add(name)
        for name in draw.sample(sorted(wishes), len(wishes)):
            if name in done:
                continue
            if name in holding:
                for index in wishes[name]:
                    nodes[index].renew(name)
                continue
            taken: list[int] = []
            for index, robots in wishes[name].items():
                try:
                    nodes[index].acquire(want(name, *robots, waits=True), 0.0)
                except RequestRefused:
                    for each in taken:
                        nodes[each].release(name, waits=True)
                    break
                taken.append(index)
            else:
                holding[name] = 0
        if len(done) == len(wishes):
            return
    pytest.fail(f"{sorted(wishes.keys() - done)} wait for ever")


@pytest.mark.parametrize("is_seen_first", [True, False])
def test_a_holder_without_heartbeats_is_observed_by_its_token(
    leases: Leases, clock: Clock, *, is_seen_first: bool
) -> None:
    quiet = want("one", "a").model_copy(update={"gives_signs": False})
    if is_seen_first:  # it is declared before the robots are asked for
        leases.token_changed(public_holder_name("one"), is_alive=True)
    leases.acquire(quiet, 0.0)
    if not is_seen_first:
        leases.token_changed(public_holder_name("one"), is_alive=True)
    clock.now += 10.0 * UNSEEN
    assert leases.within() is None
    assert not leases.overdue()
    hold = leases.token_changed(public_holder_name("one"), is_alive=False)
    assert hold is not None
    assert hold.holds("a")
    leases.release("one")
    leases.acquire(quiet, 0.0)
    clock.now += UNSEEN
    assert [describe_silence(late) for late in leases.overdue()] == ["not seen for 5 s"]


def test_lost_tokens_of_clients_without_robots_have_no_effect(leases: Leases) -> None:
    leases.token_changed(public_holder_name("one"), is_alive=True)
    assert leases.token_changed(public_holder_name("one"), is_alive=False) is None
    assert leases.token_changed(public_holder_name("two"), is_alive=False) is None


def test_holders_must_reappear_after_a_reconnection(leases: Leases, clock: Clock) -> None:
    """The node reconnects."""
    for name, robot, signs in (("quiet", "a", False), ("loud", "b", True)):
        leases.token_changed(public_holder_name(name), is_alive=True)
        leases.acquire(want(name, robot).model_copy(update={"gives_signs": signs}), 0.0)
    clock.now += HOLD_DEADLINE / 2.0
    leases.lose_connection()
    assert leases.within() == pytest.approx(HOLD_DEADLINE / 2.0)  # not longer than before
    leases.renew("loud")
    clock.now += UNSEEN
    assert [late.holder.holder for late in leases.overdue()] == ["quiet", "loud"]
    leases.token_changed(public_holder_name("quiet"), is_alive=True)
    assert [late.holder.holder for late in leases.overdue()] == ["loud"]


def test_leases_survive_a_short_loss_of_the_connection(leases: Leases, clock: Clock) -> None:
    """After a restart of the router, a waiting client reconnects first."""
    leases.acquire(want("one", "a"), 0.0)
    clock.now += HOLD_DEADLINE + 1.0
    for late in leases.overdue():
        expire(late, "no heartbeat")
    leases.lose_connection()
    for wanted in (want("two", "a", waits=True), want("two")):
        with pytest.raises(RequestRefused, match=r"'a' is kept for run one, whose connection was lost"):
            leases.acquire(wanted, 0.0)
    leases.acquire(want("two", "b"), 0.0)
    leases.renew("one")
    leases.check("one", "a", has_to_hold=True)
    clock.now += HOLD_PATIENCE
    leases.release("two")
    for late in leases.overdue():
        expire(late, "no heartbeat")
    leases.lose_connection()  # it has given up since
    leases.acquire(want("three", "a"), 0.0)


def test_events_without_a_robot_are_sent_to_no_holder() -> None:
    happened = LoggedEvents(number=1, events=(LoggedEvent(number=1, world=WorldChange(number=2, world="maze")),))
    assert events_for(Hold(want("one", "a"), 0.0), happened) == LoggedEvents(number=1)

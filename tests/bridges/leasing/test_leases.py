"""Who has which robots: all or none, one at a time, in the order of those who wait."""

from __future__ import annotations

import random

import pytest

from seoro.bridges.leasing.leases import UNSEEN, Hold, Leases, lapse, silence
from seoro.bridges.leasing.share import share_of
from seoro.bridges.wire.happened import AnotherWorld, Happening, Happenings
from seoro.bridges.wire.holding import HOLD_DEADLINE, HOLD_PATIENCE, QUEUE_PATIENCE, Holder
from seoro.bridges.wire.keys import shown_holder
from seoro.bridges.wire.lab import LeaseRobots, ReleaseLease
from seoro.bridges.wire.refusal import RequestRefused
from seoro.bridges.wire.results import LabResult


class Clock:
    """A clock that is set by hand."""

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


def test_robots_are_had_all_or_none(leases: Leases) -> None:
    leases.take(want("one", "b"), 0.0)
    with pytest.raises(RequestRefused, match="'b' is held by run one: wait for its end") as refused:
        leases.take(want("two", "a", "b"), 0.0)
    assert refused.value.code == LabResult.HELD
    assert leases.holder_of("a") is None
    leases.take(want("two", "a", "c"), 0.0)
    leases.release("one")
    leases.take(want("three", "b"), 0.0)


def test_no_robots_are_all_of_them(leases: Leases) -> None:
    leases.take(want("one"), 0.0)
    with pytest.raises(RequestRefused, match="'a' is held by run one"):
        leases.take(want("two", "a"), 0.0)
    leases.release("one")
    leases.take(want("two", "a"), 0.0)
    with pytest.raises(RequestRefused, match="'a' is held by run two"):
        leases.take(want("one"), 0.0)


def test_a_robot_that_is_not_there_is_named(leases: Leases) -> None:
    with pytest.raises(RequestRefused, match="there is no robot 'd': there are a, b, c"):
        leases.take(want("one", "d"), 0.0)


def test_only_who_holds_a_robot_may_move_it(leases: Leases) -> None:
    leases.take(want("one", "a"), 0.0)
    leases.check("one", "a", has_to_hold=True)
    leases.check("", "b", has_to_hold=False)
    with pytest.raises(RequestRefused, match="the robot 'a' is held by run one"):
        leases.check("two", "a", has_to_hold=False)
    with pytest.raises(RequestRefused, match="nobody holds the robot 'b'"):
        leases.check("one", "b", has_to_hold=True)
    with pytest.raises(RequestRefused, match="only a are held"):
        leases.check_all("one")


def test_a_client_without_signs_of_life_is_overdue_and_may_be_back(leases: Leases, clock: Clock) -> None:
    leases.take(want("one", "a"), 0.0)
    clock.now += HOLD_DEADLINE - 0.01
    leases.renew("one")
    clock.now += HOLD_DEADLINE
    (hold,) = leases.overdue()
    hold.is_alive = False
    assert leases.holder_of("a") is None
    leases.renew("one")
    assert leases.holder_of("a") is hold
    hold.is_alive = False
    assert leases.take(want("two", "a"), 0.0) == (hold,)
    with pytest.raises(RequestRefused, match="not held by this run any more: run two has them"):
        leases.renew("one")


def test_those_who_wait_come_in_the_order_of_their_priority_and_arrival(leases: Leases) -> None:
    leases.take(want("one", "a"), 0.0)
    for name, priority in (("two", 0), ("three", 0), ("four", 1)):
        with pytest.raises(RequestRefused):
            leases.take(want(name, "a", waits=True, priority=priority), 0.0)
    assert leases.waiting_for("a") == ("run four", "run two", "run three")
    leases.release("one")
    with pytest.raises(RequestRefused, match="run four waits for 'a' already, and comes first"):
        leases.take(want("two", "a", waits=True), 0.0)
    with pytest.raises(RequestRefused, match="comes first"):
        leases.take(want("five", "a"), 0.0)
    leases.take(want("four", "a", waits=True, priority=1), 0.0)
    leases.release("four")
    leases.take(want("two", "a", waits=True), 0.0)


def test_one_who_wants_more_is_not_overtaken_again_and_again(leases: Leases) -> None:
    leases.take(want("one", "a"), 0.0)
    with pytest.raises(RequestRefused):
        leases.take(want("both", "a", "b", waits=True), 0.0)
    with pytest.raises(RequestRefused, match="run both waits"):
        leases.take(want("small", "b", waits=True), 0.0)


def test_a_place_in_line_is_lost_by_not_asking(leases: Leases, clock: Clock) -> None:
    leases.take(want("one", "a"), 0.0)
    with pytest.raises(RequestRefused):
        leases.take(want("two", "a", waits=True), 0.0)
    leases.release("one")
    clock.now += QUEUE_PATIENCE
    leases.take(want("three", "a"), 0.0)


def test_who_does_not_wait_any_more_holds_up_nobody(leases: Leases) -> None:
    leases.take(want("one", "a"), 0.0)
    for waits in (True, False):
        with pytest.raises(RequestRefused):
            leases.take(want("two", "a", waits=waits), 0.0)
    leases.release("one")
    leases.take(want("three", "a"), 0.0)


def test_what_is_leased_by_hand_is_for_runs_that_name_the_lease(leases: Leases) -> None:
    leases.lease(LeaseRobots(lease="hand", robots=("a",), purpose="new wheels", duration=60.0))
    with pytest.raises(RequestRefused, match=r"'a' is leased until .* \(new wheels\)"):
        leases.take(want("one", "a"), 0.0)
    with pytest.raises(RequestRefused, match="leased until"):
        leases.check("", "a", has_to_hold=False)
    leases.take(want("one", "a", lease="hand"), 0.0)
    with pytest.raises(RequestRefused, match="held by run one"):
        leases.lease(LeaseRobots(lease="other", robots=("a",), duration=60.0))
    leases.release("one")
    leases.end_lease(ReleaseLease(robot="a"))
    leases.take(want("two", "a"), 0.0)
    with pytest.raises(RequestRefused, match="there is no lease of 'a'"):
        leases.end_lease(ReleaseLease(robot="a"))


def test_leases_by_hand_end_by_themselves(leases: Leases, monkeypatch: pytest.MonkeyPatch) -> None:
    leases.lease(LeaseRobots(lease="hand", robots=("a",), duration=60.0))
    now = leases.lease_of("a")
    assert now is not None
    monkeypatch.setattr("time.time", lambda: now.until + 1.0)
    assert leases.lease_of("a") is None
    leases.take(want("one", "a"), 0.0)


@pytest.mark.parametrize("seed", range(20))
def test_everybody_gets_their_robots_of_several_nodes_in_the_end(seed: int) -> None:
    """Clients that ask several nodes in one order, and give back what they got when they do not get the rest."""
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
                    nodes[index].take(want(name, *robots, waits=True), 0.0)
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
def test_who_gives_no_signs_of_life_has_its_token_to_be_seen_by(
    leases: Leases, clock: Clock, *, is_seen_first: bool
) -> None:
    quiet = want("one", "a").model_copy(update={"gives_signs": False})
    if is_seen_first:  # it is declared before the robots are asked for
        leases.see(shown_holder("one"))
    leases.take(quiet, 0.0)
    if not is_seen_first:
        leases.see(shown_holder("one"))
    clock.now += 10.0 * UNSEEN
    assert leases.within() is None
    assert not leases.overdue()
    hold = leases.lose(shown_holder("one"))
    assert hold is not None
    assert hold.has("a")
    leases.release("one")
    leases.take(quiet, 0.0)
    clock.now += UNSEEN
    assert [silence(late) for late in leases.overdue()] == ["not seen for 5 s"]


def test_who_holds_nothing_loses_nothing(leases: Leases) -> None:
    leases.see(shown_holder("one"))
    assert leases.lose(shown_holder("one")) is None
    assert leases.lose(shown_holder("two")) is None


def test_who_cannot_be_seen_has_to_be_seen_again(leases: Leases, clock: Clock) -> None:
    """As when a node opens its connections anew."""
    for name, robot, signs in (("quiet", "a", False), ("loud", "b", True)):
        leases.see(shown_holder(name))
        leases.take(want(name, robot).model_copy(update={"gives_signs": signs}), 0.0)
    clock.now += HOLD_DEADLINE / 2.0
    leases.lose_sight()
    assert leases.within() == pytest.approx(HOLD_DEADLINE / 2.0)  # which is no longer than before
    leases.renew("loud")
    clock.now += UNSEEN
    assert [late.holder.holder for late in leases.overdue()] == ["quiet", "loud"]
    leases.see(shown_holder("quiet"))
    assert [late.holder.holder for late in leases.overdue()] == ["loud"]


def test_robots_are_kept_for_a_moment_when_the_connection_of_the_node_was_lost(
    leases: Leases, clock: Clock
) -> None:
    """As when a router is started again: whoever waits is back first."""
    leases.take(want("one", "a"), 0.0)
    clock.now += HOLD_DEADLINE + 1.0
    for late in leases.overdue():
        lapse(late, "no sign of life")
    leases.lose_sight()
    for wanted in (want("two", "a", waits=True), want("two")):
        with pytest.raises(RequestRefused, match=r"'a' is kept for run one, whose connection was lost"):
            leases.take(wanted, 0.0)
    leases.take(want("two", "b"), 0.0)
    leases.renew("one")
    leases.check("one", "a", has_to_hold=True)
    clock.now += HOLD_PATIENCE
    leases.release("two")
    for late in leases.overdue():
        lapse(late, "no sign of life")
    leases.lose_sight()  # it has given up since
    leases.take(want("three", "a"), 0.0)


def test_what_happens_to_no_robot_is_nobodys_share() -> None:
    happened = Happenings(number=1, happenings=(Happening(number=1, world=AnotherWorld(number=2, world="maze")),))
    assert share_of(Hold(want("one", "a"), 0.0), happened) == Happenings(number=1)

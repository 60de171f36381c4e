"""Many small grants are answered with few requests, and nobody can tell."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import pytest

from seoro.bridges import wire
from seoro.bridges.conformance import Make
from seoro.bridges.conformance.bench import BOX, Bench, Reports, place, started
from seoro.bridges.sim.node import SimulatorNode
from seoro.bridges.sim.passing import FAMILIAR, FURTHEST, Foresight
from seoro.runtime.capabilities import DrivenRobots, MobileRobots, Simulation
from tests.bridges.nodes import running

GRANT = 0.02  # [s]


@pytest.fixture(scope="module", params=["mujoco", "pybullet"])
def make(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Make]:
    pytest.importorskip(request.param, reason=f"the engine {request.param} is not installed")
    with running(request.param, tmp_path_factory.mktemp("n")) as making:
        yield making


class Counter:
    """Counts the requests that a backend makes."""

    def __init__(self, bench: Bench) -> None:
        node = bench.backend
        assert isinstance(node, SimulatorNode)
        session: Any = node._address.session
        self.verbs: list[str] = []
        query = session.query

        async def counted(key: str, *arguments: Any, **options: Any) -> bytes:
            self.verbs.append(key.rsplit("/", 1)[-1])
            return bytes(await query(key, *arguments, **options))

        vars(session)["query"] = counted


async def grant_often(bench: Bench, until: float) -> None:
    while bench.time < until:
        await bench.grant(min(until, bench.time + GRANT))


async def grant_to_the_end_of_what_is_known(bench: Bench, node: SimulatorNode) -> None:
    """Grant until the next grant has to be asked for, and has a horizon."""
    await grant_often(bench, bench.time + (FAMILIAR + 1) * GRANT)
    while node._ahead is not None:
        await bench.grant(bench.time + GRANT)


async def test_a_hundred_small_grants_are_a_few_requests(make: Make) -> None:
    async with started(make) as bench:
        await bench.can(DrivenRobots).drive(bench.robot, 0.1, 0.0, 20.0, Reports())
        counter = Counter(bench)
        await grant_often(bench, 10.0)
        assert counter.verbs.count("advance") < FAMILIAR + 15
        assert set(counter.verbs) == {"advance"}


async def test_who_asks_after_each_grant_never_has_to_come_back(make: Make) -> None:
    async with started(make) as bench:
        counter = Counter(bench)
        for _ in range(20):
            await grant_often(bench, bench.time + 3 * GRANT)
            await bench.truth()
        assert "rewind" not in counter.verbs


async def seen(make: Make, *, goes_ahead: bool) -> list[object]:
    """What is seen of a run in small grants, with questions, and a box that the robot hits."""
    found: list[object] = []
    async with started(make) as bench:
        node, reports = bench.backend, Reports()
        assert isinstance(node, SimulatorNode)
        if not goes_ahead:
            node._rewinds = False
        counter = Counter(bench)
        await bench.can(Simulation).spawn_entity("box", BOX, place(0.9, 0.0))
        await bench.can(DrivenRobots).drive(bench.robot, 0.3, 0.05, 4.0, reports)
        await bench.can(MobileRobots).watch_distance(bench.robot, 0.5, reports)
        for until in (0.3, 1.17, 1.171, 2.5, 2.6, 6.0):
            await grant_often(bench, until)
            found += [bench.time, await bench.truth(), list(reports.statuses), list(bench.happened)]
        assert ("rewind" in counter.verbs) == goes_ahead
    return found


async def test_going_ahead_changes_nothing(make: Make) -> None:
    assert await seen(make, goes_ahead=True) == await seen(make, goes_ahead=False)


async def test_a_grant_that_is_given_up_leaves_the_node_where_it_was_to_end(make: Make) -> None:
    async with started(make) as bench:
        await grant_often(bench, 2 * FAMILIAR * GRANT)
        assert isinstance(bench.backend, SimulatorNode)
        await grant_to_the_end_of_what_is_known(bench, bench.backend)
        before = bench.time
        granting = asyncio.ensure_future(bench.backend.advance(before + 0.1))
        await asyncio.sleep(0)
        await asyncio.sleep(0)
        granting.cancel()
        with suppress(asyncio.CancelledError):
            await granting
        await bench.truth()
        features = await bench.backend.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())
        assert features.time == pytest.approx(before + 0.1)


async def test_what_is_asked_for_during_a_grant_is_done_where_that_was_to_end(make: Make) -> None:
    async with started(make) as bench:
        await grant_often(bench, 2 * FAMILIAR * GRANT)
        node = bench.backend
        assert isinstance(node, SimulatorNode)
        await node.drive(bench.robot, 0.2, 0.0, 30.0, Reports())
        await grant_to_the_end_of_what_is_known(bench, node)
        end = bench.time + GRANT
        granting = asyncio.ensure_future(node.advance(end))
        await asyncio.sleep(0)
        asked = [asyncio.ensure_future(node.ask(wire.GET_SIMULATOR_FEATURES, wire.Empty())) for _ in range(3)]
        features = await asyncio.gather(*asked)
        assert [each.time for each in features] == [pytest.approx(end, abs=0.005)] * 3
        assert await granting == pytest.approx(end, abs=0.005)
        assert await node.advance(end + GRANT) == pytest.approx(end + GRANT, abs=0.005)


def test_the_further_the_longer_nothing_is_asked_for() -> None:
    foresight = Foresight()
    ahead = []
    now = 0.0
    for _ in range(FAMILIAR + 15):
        until = now + GRANT
        horizon = foresight.horizon(now, until)
        ahead.append(None if horizon is None else round((horizon - until) / GRANT))
        now = until
    assert ahead[:FAMILIAR] == [None] * FAMILIAR
    assert ahead[FAMILIAR : FAMILIAR + 4] == [2, 4, 8, 16]
    assert ahead[-1] == round(FURTHEST / GRANT)


def test_long_grants_and_grants_of_the_past_are_granted_as_they_are() -> None:
    foresight = Foresight()
    grants = [until for until in (2 * FURTHEST, 0.0, -1.0) for _ in range(FAMILIAR + 1)]
    assert {foresight.horizon(0.0, until) for until in grants} == {None}


def test_what_happens_at_once_is_not_gone_ahead_of() -> None:
    foresight = Foresight()
    for _ in range(FAMILIAR):
        foresight.horizon(0.0, GRANT)
    assert foresight.horizon(0.0, GRANT) is not None
    foresight.ended(0.0)
    assert foresight.horizon(0.0, GRANT) is None

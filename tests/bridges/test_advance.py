"""Many small grants need few requests, with the same results."""

from __future__ import annotations

import asyncio
from collections.abc import Iterator
from contextlib import suppress
from typing import Any

import pytest

from seoro.bridges import wire
from seoro.bridges.conformance import Make
from seoro.bridges.conformance.bench import BOX, Bench, Reports, place, started
from seoro.bridges.sim.advance import MAX_HORIZON, QUIET_GRANTS, Lookahead
from seoro.bridges.sim.node import SimulatorNode
from seoro.runtime.contracts.robots import DrivenRobots, MobileRobots
from seoro.runtime.contracts.worlds import Simulation
from tests.bridges.nodes import running

GRANT = 0.02  # [s]


@pytest.fixture(scope="module", params=["mujoco", "pybullet"])
def make(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Make]:
    pytest.importorskip(request.param, reason=f"the engine {request.param} is not installed")
    with running(request.param, tmp_path_factory.mktemp("n")) as making:
        yield making


class Counter:
    """A counter of the requests of a backend."""

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
    """Grant time until the next grant needs a request with a horizon."""
    await grant_often(bench, bench.time + (QUIET_GRANTS + 1) * GRANT)
    while node._ahead is not None:
        await bench.grant(bench.time + GRANT)


async def test_many_small_grants_need_few_requests(make: Make) -> None:
    async with started(make) as bench:
        await bench.cast(DrivenRobots).drive(bench.robot, 0.1, 0.0, 20.0, Reports())
        counter = Counter(bench)
        await grant_often(bench, 10.0)
        assert counter.verbs.count("advance") < QUIET_GRANTS + 15
        assert set(counter.verbs) == {"advance"}


async def feedback_of(make: Make, grant: float, *, goes_ahead: bool) -> tuple[list[object], int]:
    """Return the feedback of a robot that navigates with the times of its reports, and the number of grants."""
    async with started(make) as bench:
        node = bench.backend
        assert isinstance(node, SimulatorNode)
        node._rewinds &= goes_ahead
        await bench.cast(MobileRobots).set_initial_pose(bench.robot, place(0.0, 0.0))
        counter = Counter(bench)
        await node.navigate(bench.robot, [place(3.0, 3.0)], stop_at_each=False, report=Reports())
        found: list[object] = []
        while bench.time < 8.0:
            bench.happened.clear()
            await bench.grant(round(bench.time + grant, 9))
            found += [(bench.time, *each) for each in bench.happened]
            if bench.time == pytest.approx(6.0):  # inside an answer that goes ahead
                found.append(await bench.truth())
        return found, counter.verbs.count("advance")


@pytest.mark.parametrize("grant", [1.0, 0.3])
async def test_feedback_needs_no_requests_and_keeps_its_times(make: Make, grant: float) -> None:
    expected, grants = await feedback_of(make, grant, goes_ahead=False)
    found, fewer = await feedback_of(make, grant, goes_ahead=True)
    assert found == expected
    assert len(found) >= 8
    assert fewer < grants


async def test_a_request_after_each_grant_causes_no_rewind(make: Make) -> None:
    async with started(make) as bench:
        counter = Counter(bench)
        for _ in range(20):
            await grant_often(bench, bench.time + 3 * GRANT)
            await bench.truth()
        assert "rewind" not in counter.verbs


async def seen(make: Make, *, goes_ahead: bool) -> list[object]:
    """Record a run in small grants, with queries and a box that the robot hits."""
    found: list[object] = []
    async with started(make) as bench:
        node, reports = bench.backend, Reports()
        assert isinstance(node, SimulatorNode)
        if not goes_ahead:
            node._rewinds = False
        counter = Counter(bench)
        samples: list[object] = []
        await node.start_tracks(10.0, samples.append)
        await bench.cast(Simulation).spawn_entity("box", BOX, place(0.9, 0.0))
        await bench.cast(DrivenRobots).drive(bench.robot, 0.3, 0.05, 4.0, reports)
        await bench.cast(MobileRobots).watch_distance(bench.robot, 0.5, reports)
        for until in (0.3, 1.17, 1.171, 2.5, 2.6, 6.0):
            await grant_often(bench, until)
            found += [bench.time, await bench.truth(), list(reports.statuses), list(bench.happened), list(samples)]
        assert ("rewind" in counter.verbs) == goes_ahead
        assert len(samples) > 40
    return found


async def test_lookahead_does_not_change_a_run(make: Make) -> None:
    assert await seen(make, goes_ahead=True) == await seen(make, goes_ahead=False)


async def test_a_cancelled_grant_leaves_the_node_at_its_end(make: Make) -> None:
    async with started(make) as bench:
        await grant_often(bench, 2 * QUIET_GRANTS * GRANT)
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


async def test_requests_during_a_grant_are_handled_at_its_end(make: Make) -> None:
    async with started(make) as bench:
        await grant_often(bench, 2 * QUIET_GRANTS * GRANT)
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


def test_the_horizon_grows_while_no_request_arrives() -> None:
    foresight = Lookahead()
    ahead = []
    now = 0.0
    for _ in range(QUIET_GRANTS + 15):
        until = now + GRANT
        horizon = foresight.horizon(now, until)
        ahead.append(None if horizon is None else round((horizon - until) / GRANT))
        now = until
    assert ahead[:QUIET_GRANTS] == [None] * QUIET_GRANTS
    assert ahead[QUIET_GRANTS : QUIET_GRANTS + 4] == [2, 4, 8, 16]
    assert ahead[-1] == round(MAX_HORIZON / GRANT)


def test_long_and_past_grants_have_no_lookahead() -> None:
    foresight = Lookahead()
    grants = [until for until in (2 * MAX_HORIZON, 0.0, -1.0) for _ in range(QUIET_GRANTS + 1)]
    assert {foresight.horizon(0.0, until) for until in grants} == {None}


@pytest.mark.more
def test_a_grant_that_ends_at_once_stops_the_lookahead() -> None:
    foresight = Lookahead()
    for _ in range(QUIET_GRANTS):
        foresight.horizon(0.0, GRANT)
    assert foresight.horizon(0.0, GRANT) is not None
    foresight.ended(0.0)
    assert foresight.horizon(0.0, GRANT) is None

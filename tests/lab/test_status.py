"""Connections to the endpoints of a lab."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.launch import SimulatorOptions, connect_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.session import AsyncSession, open_session
from seoro.bridges.sim.requests import ask
from seoro.lab import status
from seoro.lab.status import connect_members
from tests.lab.nodes import hall_at

pytestmark = pytest.mark.anyio


async def test_all_endpoints_are_queried_at_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    nowhere, hub = (f"unixsock-stream/{tmp_path}/{name}" for name in ("nowhere", "hub"))
    tried: set[str] = set()
    all_tried = anyio.Event()

    @asynccontextmanager
    async def opening(*, connect: str, security: None) -> AsyncIterator[AsyncSession]:
        tried.add(connect)
        if tried == {nowhere, hub}:
            all_tried.set()
        await all_tried.wait()
        async with open_session(connect=connect, security=security) as session:
            yield session

    monkeypatch.setattr(status, "open_session", opening)
    with anyio.fail_after(30.0):
        async with open_session(listen=hub), connect_members([nowhere, hub, nowhere]) as reached:
            assert [(each.member.endpoint, each.session is None) for each in reached] == [
                (nowhere, True),
                (hub, False),
            ]
            assert "cannot connect" in reached[0].member.problem
            assert "no node or executor" in reached[1].member.problem


async def test_a_viewer_changes_nothing_for_a_run_that_the_simulator_is_ahead_of(tmp_path: Path) -> None:
    found = []
    with hall_at(tmp_path, rate=None) as hall:
        for is_viewed in (False, True):
            options = SimulatorOptions("hall", 1, ModelPath())
            async with connect_simulator(hall.endpoint, options, purpose="a run") as node:
                await node.start_run(lambda name, arguments: None, lambda lost: None)
                await node.drive("second", 0.2, 0.1, 20.0, lambda report: None)
                for grant in range(1, 40):
                    while await node.advance(grant * 0.02) < grant * 0.02 - 1e-6:  # until the next event
                        pass
                if is_viewed:
                    ahead = await time_of(hall.endpoint)
                    assert ahead > node.time + 0.1
                    (member,) = await status.read_states([hall.endpoint])
                    assert member.state is not None
                state = await node.ask(wire.GET_ENTITY_STATE, wire.EntityName(name="second"))
                found.append(state.pose)
    assert found[0] == found[1]


async def time_of(endpoint: str) -> float:
    """Return the time of a simulator, which may be ahead of its run."""
    async with connect_members([endpoint]) as (member,):
        assert member.session is not None
        return (await ask(member.address(member.session), wire.GET_SIMULATOR_FEATURES, wire.Empty())).time

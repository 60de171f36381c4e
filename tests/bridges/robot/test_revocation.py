"""Bridges that listen with keys: revoked clients are disconnected, and robots of others drive on."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import suppress

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.robot.connecting import connect_robots
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.session import NoAnswer, NoServer, open_session
from seoro.bridges.wire.keys import node_command
from seoro.errors import BackendError, BackendLost
from seoro.runtime.contracts.backends import Report
from seoro.security.keys import VARIABLE
from seoro.security.keys.folder import read_keys
from seoro.security.keys.roles import Role
from seoro.security.network.endpoint_keys import security_of
from tests.bridges.robot.conftest import Rails, rails_at
from tests.labs import KeyedLab, free_port, make_lab

pytestmark = pytest.mark.anyio

DEADLINE = 30.0  # [s]
NODE = "rails"


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    made = make_lab(tmp_path_factory.mktemp("lab"))
    made.authority.add(NODE, Role.NODE, made.keys(NODE))
    return made


@pytest.fixture(scope="module")
def all_rails(lab: KeyedLab, tmp_path_factory: pytest.TempPathFactory) -> Iterator[Rails]:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    with rails_at(tmp_path_factory.mktemp("rails"), "--listen", endpoint, keys=lab.keys(NODE)) as running:
        yield running


async def again(node: RobotNode) -> None:
    """Wait until a run is connected again; its requests fail meanwhile."""
    with anyio.fail_after(DEADLINE):
        while True:
            with suppress(BackendLost):
                await node.ask(wire.GET_LAB_STATE, wire.Empty())
                return
            await anyio.sleep(0.01)


async def test_revoked_keys_end_their_run_and_other_runs_continue(
    rails: Rails, lab: KeyedLab, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv(VARIABLE, str(lab.keys("anna")))
    security = security_of(rails.endpoint, read_keys(lab.keys("vera")))
    reports: list[Report] = []
    async with (
        open_session(connect=rails.endpoint, security=security) as vera,
        connect_robots(rails.endpoint, "a run") as node,
    ):
        key = node_command(wire.NAMESPACE, NODE, wire.GET_LAB_STATE.name)
        await vera.query(key, wire.encode(wire.Empty()), 5.0)
        await node.drive("line", 0.2, 0.0, 600.0, reports.append)
        lab.revoke("vera", NODE)
        with anyio.fail_after(DEADLINE), pytest.raises((NoServer, NoAnswer)):
            while True:
                await vera.query(key, wire.encode(wire.Empty()), 0.5)
        await again(node)
        with pytest.raises((NoServer, NoAnswer)):
            await vera.query(key, wire.encode(wire.Empty()), 0.5)
        with anyio.fail_after(DEADLINE):
            while rails.commands()[-1][2] != 0.2:
                # On a busy machine, connections are not back before the robot has to be stopped.
                with suppress(BackendError):
                    await node.drive("line", 0.2, 0.0, 600.0, reports.append)
                await anyio.sleep(0.01)
        assert all("no heartbeat" in report.message for report in reports)
    assert rails.commands()[-1][2] == 0.0

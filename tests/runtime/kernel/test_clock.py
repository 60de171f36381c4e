"""Clocks alone."""

import asyncio
import math

import anyio
import pytest

from seoro.runtime.kernel.clock import HORIZON, PACED_GRANT, RealClock, SimulatorClock, VirtualClock


class Server:
    """A simulator that advances to the granted time, but never beyond its next event."""

    def __init__(self, happens_at: float = math.inf) -> None:
        self.grants: list[float] = []
        self.happens_at = happens_at

    async def advance(self, until: float) -> float:
        self.grants.append(until)
        return min(until, self.happens_at)


async def test_virtual_time_jumps_to_the_next_deadline() -> None:
    clock = VirtualClock()
    clock.start()
    with anyio.fail_after(30.0):
        await clock.pass_time(3600.0, asyncio.Event())
    assert clock.now() == 3600.0


async def test_virtual_time_stands_still_without_a_deadline() -> None:
    clock = VirtualClock()
    interrupt = asyncio.Event()
    interrupt.set()
    await clock.pass_time(None, interrupt)
    assert clock.now() == 0.0


async def test_real_time_passes_until_it_is_due() -> None:
    clock = RealClock()
    clock.start()
    await clock.pass_time(0.01, asyncio.Event())
    assert clock.now() >= 0.01


async def test_real_time_is_interrupted_by_arrivals() -> None:
    clock = RealClock()
    clock.start()
    interrupt = asyncio.Event()
    interrupt.set()
    with anyio.fail_after(30.0):
        await clock.pass_time(None, interrupt)
    assert clock.now() < 10.0


async def test_a_simulator_is_granted_time_until_the_next_deadline() -> None:
    server = Server()
    clock = SimulatorClock(server, math.inf)
    clock.start()
    await clock.pass_time(0.7, asyncio.Event())
    assert server.grants == [0.7]
    assert clock.now() == 0.7


async def test_a_grant_without_a_deadline_ends_at_the_horizon() -> None:
    server = Server()
    clock = SimulatorClock(server, math.inf)
    clock.start()
    await clock.pass_time(None, asyncio.Event())
    assert server.grants == [HORIZON]


async def test_a_simulator_may_come_back_early() -> None:
    clock = SimulatorClock(Server(happens_at=0.3), math.inf)
    clock.start()
    await clock.pass_time(0.7, asyncio.Event())
    assert clock.now() == 0.3


async def test_a_rate_is_kept_in_short_grants(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.runtime.kernel.clock.time.monotonic", lambda: 0.0)
    limits: list[float] = []

    def timeout(delay: float) -> asyncio.Timeout:
        limits.append(delay)
        return asyncio.Timeout(None)

    monkeypatch.setattr("seoro.runtime.kernel.clock.asyncio.timeout", timeout)
    server = Server()
    clock = SimulatorClock(server, 2.0)
    clock.start()
    interrupt = asyncio.Event()
    interrupt.set()
    await clock.pass_time(10.0, interrupt)
    assert server.grants == [PACED_GRANT]
    assert limits == [PACED_GRANT / 2.0]

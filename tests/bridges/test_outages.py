"""Outages of connections, and the waits that they affect."""

import time
from typing import Any, cast

import pytest

from seoro.bridges import wire
from seoro.bridges.robot import node
from seoro.bridges.robot.node import RobotNode
from seoro.bridges.session import NoServer, Outages
from seoro.bridges.sim.requests import NodeAddress
from seoro.bridges.wire.holds import HOLD_DEADLINE


class Times:
    """A clock that a test sets."""

    def __init__(self) -> None:
        self.now = 100.0

    def monotonic(self) -> float:
        return self.now


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Times:
    times = Times()
    monkeypatch.setattr(time, "monotonic", times.monotonic)
    return times


def test_an_outage_affects_waits_that_began_before_its_end(clock: Times) -> None:
    outages = Outages(is_connected=True)
    assert not outages.since(0.0)
    outages.change(False)
    assert outages.since(clock.now)
    clock.now = 105.0
    outages.change(True)
    assert outages.since(104.0)
    assert not outages.since(105.0)


def test_one_of_two_connections_is_enough(clock: Times) -> None:
    outages = Outages(is_connected=True)
    outages.change(True)
    outages.change(False)
    assert not outages.since(0.0)


class Node:
    """A node that replies to heartbeats after given delays; None for a missing reply."""

    display_name, node, sender, session = "robot", "rails", "", None

    def __init__(self, clock: Times, gaps: list[float | None]) -> None:
        self._clock = clock
        self._gaps = gaps

    async def query(self, *_: object) -> bytes:
        if not self._gaps:
            raise EndOfTest
        gap = self._gaps.pop(0)
        if gap is None:
            raise NoServer("nobody")
        self._clock.now += gap
        return wire.encode(wire.LoggedEvents(number=0, events=()))


class EndOfTest(Exception):
    """Ends a loop without an end of its own."""


async def held(clock: Times, *gaps: float | None) -> RobotNode:
    """Return robots whose node replies after given times [s]."""
    address = cast("NodeAddress", cast("Any", Node(clock, list(gaps))))
    robots = RobotNode(
        address, wire.Holder(holder="me"), wire.RobotFeatures(version="", features=(), robots=(), number=0)
    )
    with pytest.raises(EndOfTest):
        await robots.send_heartbeats()
    return robots


async def test_a_short_outage_of_a_held_robot_misses_nothing(clock: Times) -> None:
    robots = await held(clock, 0.05, HOLD_DEADLINE, 0.05)
    assert robots.loss_since(0.0) == ""


async def test_a_standstill_affects_waits_that_began_before_it(
    clock: Times, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(node, "RETRY", 0.0)
    robots = await held(clock, 0.05, None, 1.0, 0.05)
    assert robots.loss_since(100.5) == "robot 'rails' was unreachable meanwhile, and its robots stood still"
    assert robots.loss_since(clock.now) == ""


async def test_an_unreachable_node_affects_all_waits(clock: Times, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(node, "RETRY", 0.0)
    robots = await held(clock, 0.05, None)
    assert robots.loss_since(clock.now) == "robot 'rails' does not answer"

"""Counts of work in a tick, which must not grow unnoticed."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from typing import Any

import pytest

from seoro.bridges import wire
from sim_nodes import clearance
from sim_nodes.__main__ import ENGINES
from sim_nodes.noise import Noise
from sim_nodes.robots.mobile import MobileBase
from tests.sim_nodes.client import ROBOT, Client, pose

TICKS = 50


def count(monkeypatch: pytest.MonkeyPatch, calls: Counter[str], owner: object, *names: str) -> None:
    """Count the calls of functions of a class or module."""
    for name in names:
        monkeypatch.setattr(owner, name, _counted(getattr(owner, name), name, calls))


def _counted(function: Callable[..., Any], name: str, calls: Counter[str]) -> Callable[..., Any]:
    def call(*arguments: Any, **named: Any) -> Any:
        calls[name] += 1
        return function(*arguments, **named)

    return call


@pytest.mark.parametrize("engine", ENGINES)
def test_a_constant_velocity_is_commanded_once_and_a_state_is_read_once_in_a_tick(
    engine: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    client = Client("empty", 0, engine)
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.2, angular=0.0, duration=5.0))
    client.advance(1.0)  # it has its full speed
    calls: Counter[str] = Counter()
    count(monkeypatch, calls, type(client.simulator.simulation.engine), "command_wheels", "_read_state")
    client.advance(1.0 + TICKS * 0.02)
    assert calls["command_wheels"] == 0
    assert calls["_read_state"] <= TICKS


def test_only_sensors_in_use_draw_random_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    client = Client("empty")
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=0.2, angular=0.0, duration=5.0))
    client.advance(1.0)
    calls: Counter[str] = Counter()
    count(monkeypatch, calls, Noise, "at")
    client.advance(1.0 + TICKS * 0.02)
    assert calls["at"] == TICKS  # of the odometry


def test_a_navigating_robot_repeats_commands_between_its_decisions(monkeypatch: pytest.MonkeyPatch) -> None:
    client = Client("empty")
    client.localise()
    client.navigate(pose(3.0, 0.0))
    client.advance(3.0)
    calls: Counter[str] = Counter()
    count(monkeypatch, calls, type(client.simulator.simulation.engine), "command_wheels")
    count(monkeypatch, calls, MobileBase, "follow_navigator")
    client.advance(3.0 + TICKS * 0.02)
    assert calls["follow_navigator"] == TICKS
    assert calls["command_wheels"] <= TICKS / 2


def test_no_outline_is_placed_while_a_robot_drives_away_from_everything(monkeypatch: pytest.MonkeyPatch) -> None:
    client = Client("empty")
    client.spawn("box", pose(0.4, 0.0, z=0.05))
    client.ask(wire.DRIVE, wire.Drive(id="drive", robot=ROBOT, linear=-0.2, angular=0.0, duration=5.0))
    client.advance(2.2)
    calls: Counter[str] = Counter()
    count(monkeypatch, calls, clearance, "placed_outline")
    client.advance(2.2 + TICKS * 0.02)
    assert calls["placed_outline"] == 0

"""Batteries of bases: power draw, and reports of the charge."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Purpose
from sim_nodes.__main__ import ENGINES
from sim_nodes.leasing import Leasing
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes.client import Client
from tests.sim_nodes.graph import differences
from tests.sim_nodes.test_snapshots import restore, save

DRIVE = wire.Drive(id="d", robot="first", linear=0.2, angular=0.0, duration=2.0)
WORLD = """name: fleet
extent: [-4, -4, 4, 4]
robots:
  - {name: first, robot: turtlebot4, battery: {capacity: 0.1, idle: 18, driving: 54, charge: 0.9}}
  - {name: second, robot: turtlebot4, pose: {y: 2}}
"""


@pytest.fixture
def world(tmp_path: Path) -> str:
    file = tmp_path / "fleet.yaml"
    file.write_text(WORLD)
    return str(file)


def charges(client: Client) -> list[float | None]:
    """Return the charges reported to a lab."""
    state = Leasing(client.simulator).get_lab_state(wire.Empty())
    return [robot.battery for robot in state.robots]


def driven(world: str, engine: str, grant: float = math.inf) -> Client:
    """Return a client after 4 s, with 2 s of driving."""
    client = Client(world, engine=engine)
    client.advance(1.0)
    client.ask(wire.DRIVE, DRIVE)
    time = client.run_until("d")[0].time
    while time < 4.0:
        time = client.advance(min(time + grant, 4.0)).time
    return client


@pytest.mark.parametrize("engine", ENGINES)
def test_a_battery_draws_different_power_at_rest_and_while_driving(world: str, engine: str) -> None:
    client = Client(world, engine=engine)
    assert charges(client) == [0.9, None]
    client.advance(1.0)
    assert charges(client) == [pytest.approx(0.9 - 18 / 3600 / 0.1), None]
    client = driven(world, engine)
    # The wheels are commanded to turn from the tick after the request on.
    assert charges(client)[0] == pytest.approx(0.9 - (2 * 18 + 2 * 54) / 3600 / 0.1, abs=0.003)


def test_the_charge_does_not_depend_on_how_time_is_granted(world: str) -> None:
    assert charges(driven(world, "mujoco")) == charges(driven(world, "mujoco", grant=0.05))


def test_the_charge_of_an_empty_battery_is_zero(world: str) -> None:
    client = Client(world)
    client.advance(20.0)
    client.ask(wire.DRIVE, DRIVE)
    client.advance(21.0)
    assert charges(client)[0] == 0.0


def test_a_snapshot_keeps_the_charge(world: str) -> None:
    original = driven(world, "mujoco")
    fork = Client("empty", 99)
    restore(fork, save(original), Purpose.CONTINUE)
    assert differences(original.simulator.simulation, fork.simulator.simulation) == []
    assert charges(fork) == charges(original)
    for client in (original, fork):
        client.advance(6.0)
    assert charges(fork) == charges(original)
    assert charges(fork)[0] == pytest.approx(0.9 - (4 * 18 + 2 * 54) / 3600 / 0.1, abs=0.003)


def test_a_battery_of_a_fixed_robot_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "cell.yaml"
    robot = "{name: a, robot: ur10e, battery: {capacity: 1, idle: 1, driving: 1}}"
    file.write_text(f"name: c\nextent: [-4, -4, 4, 4]\nrobots: [{robot}]\n")
    with pytest.raises(WorldError, match=r"robots\.0\.battery: unexpected battery: a ur10e does not drive"):
        load_world(str(file))

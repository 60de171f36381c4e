"""The size of grants does not change events and their times."""

from __future__ import annotations

import random
from collections.abc import Iterator

import pytest

from seoro.bridges import wire
from tests.sim_nodes.client import BOX, ROBOT, Client, pose
from tests.sim_nodes.engines import PYBULLET_IN_MORE

END = 6.0  # [s]


def singly(client: Client) -> Iterator[float]:
    step = 1.0 / client.simulator.simulation.engine.steps_per_second
    yield from (index * step for index in range(1, round(END / step) + 1))


def at_control_rate(_: Client) -> Iterator[float]:
    yield from (index * 0.02 for index in range(1, round(END / 0.02) + 1))


def anyhow(_: Client) -> Iterator[float]:
    draw, until = random.Random(4), 0.0
    while until < END:
        until = min(until + draw.choice((0.001, 0.01, 0.019, 0.021, 0.2, 1.3)), END)
        yield until


def at_once(_: Client) -> Iterator[float]:
    yield END


def happened(client: Client, grants: Iterator[float]) -> list[object]:
    """Return the events of a robot, idle at first, that pushes a box against a wall while another box falls."""
    client.spawn("box", pose(0.45, 0.0, z=0.1))
    client.spawn("high", pose(-0.45, 0.0, z=0.4))
    client.spawn(
        "low", pose(-0.45, 0.0, z=0.1), BOX.replace('<link name="link">', '<static>1</static><link name="link">')
    )
    seen: list[object] = []
    driven = False
    for until in grants:
        while True:
            if not driven and until > 1.0:
                before = client.advance(1.0)
                seen += [*before.contacts, *before.occurrences]
                if before.time < 1.0:
                    continue
                request = wire.Drive(id="drive", robot=ROBOT, linear=0.3, angular=0.0, duration=4.0)
                client.ask(wire.DRIVE, request)
                driven = True
            advanced = client.advance(until)
            seen += [*advanced.contacts, *advanced.occurrences]
            if advanced.time >= until:
                break
    simulation = client.simulator.simulation
    odometry = simulation.robot(ROBOT).mobile.odometry
    return [*seen, *(simulation.engine.body_state(name) for name in (ROBOT, "box", "high")), odometry.pose]


@pytest.mark.parametrize("engine", PYBULLET_IN_MORE)
def test_the_size_of_grants_changes_no_event(engine: str) -> None:
    first, *others = [
        happened(client, grants(client))
        for grants in (singly, at_control_rate, anyhow, at_once)
        for client in [Client("maze", engine=engine)]
    ]
    touched = {(each.first, each.second) for each in first if isinstance(each, wire.Contact)}
    assert {("box", ROBOT), ("box", "walls"), ("high", "low")} <= touched
    assert [other == first for other in others] == [True, True, True]


def measured(engine: str, grant: float) -> list[object]:
    """Return the measurements of bodies that slide and fall beside a robot, which is at rest at first."""
    client = Client("empty", engine=engine)
    client.spawn("box", pose(1.0, 0.6, z=0.1))
    client.spawn("falling", pose(1.0, -0.6, z=0.8))
    client.spawn("below", pose(1.0, -0.6, z=0.1))
    twist = wire.Twist(linear=wire.Vector3(x=2.0), angular=wire.Vector3())
    slide = wire.SetEntityState(name="box", pose=pose(1.0, 0.6, z=0.1), twist=twist)
    client.ask(wire.SET_ENTITY_STATE, slide)
    request = wire.Drive(id="drive", robot=ROBOT, linear=0.3, angular=0.2, duration=1.0)
    simulation = client.simulator.simulation
    for end in (1.5, 3.5):
        while simulation.time < end:
            client.advance(min(end, simulation.time + grant))
        if end == 1.5:
            client.ask(wire.DRIVE, request)
    data = simulation.run_data
    return [client.ask(wire.GET_MEASUREMENTS, wire.Empty()), data.trails, data.records[ROBOT].path]


@pytest.mark.parametrize("engine", PYBULLET_IN_MORE)
def test_the_size_of_grants_changes_no_measurement(engine: str) -> None:
    first, *others = [measured(engine, grant) for grant in (0.004, 0.03, 3.0)]
    assert [other == first for other in others] == [True, True]
    found = first[0]
    assert isinstance(found, wire.Measurements)
    assert found.entities["box"].path_length > 0.2
    assert found.entities["falling"].contacts_with == {"below": 1}

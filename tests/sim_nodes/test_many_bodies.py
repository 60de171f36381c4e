"""Hundreds of bodies are spawned, reset and deleted without leaks."""

from __future__ import annotations

import gc
import resource

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import ResetScope, Result, SpawnResult
from sim_nodes.__main__ import ENGINES
from sim_nodes.physics import BodyState
from tests.sim_nodes.client import BOX, ROBOT, Client, pose
from tests.sim_nodes.engines import PYBULLET_IN_MORE

STEPS = 5


def wish(name: str, x: float, y: float, model: str = BOX) -> wire.SpawnEntity:
    return wire.SpawnEntity(name=name, uri="box.sdf", resource_string=model, initial_pose=pose(x, y, z=0.2))


def boxes(count: int) -> tuple[wire.SpawnEntity, ...]:
    """Return requests for boxes beside each other, in rows of 25 above the floor."""
    return tuple(wish(f"box{i}", -9.0 + i % 25 * 0.74, 1.0 + i // 25 * 0.42) for i in range(count))


def names(client: Client) -> tuple[str, ...]:
    return client.ask(wire.GET_ENTITIES, wire.EntityFilter()).names


def reset(client: Client, scope: ResetScope) -> None:
    client.ask(wire.RESET_SIMULATION, wire.ResetSimulation(scope=scope))


def states(client: Client) -> list[BodyState]:
    entities = client.simulator.simulation.entities
    return [entities.state(name) for name in names(client)]


def come_and_go(client: Client, count: int, resets: int) -> None:
    """Spawn, simulate, reset and delete bodies; fail on leaks."""
    answer = client.ask(wire.SPAWN_ENTITIES, wire.SpawnEntities(entities=boxes(count)))
    assert [result.code for result in answer.results] == [Result.OK] * count
    assert len(names(client)) == count + 1
    reset(client, ResetScope.STATE)
    start = states(client)
    client.simulator.simulation.step(STEPS)
    fallen = states(client)
    for index in range(resets):
        reset(client, ResetScope.STATE)
        assert states(client) == start
        if index % 10 == 0:
            client.simulator.simulation.step(STEPS)
            assert states(client) == fallen
    reset(client, ResetScope.SPAWNED)
    assert names(client) == (ROBOT,)
    client.advance(client.simulator.simulation.time + 0.1)


@pytest.mark.parametrize("engine", PYBULLET_IN_MORE)
def test_many_bodies_are_spawned_and_deleted(engine: str) -> None:
    client = Client("empty", engine=engine)
    for _ in range(2):
        come_and_go(client, 40, 3)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
def test_deleting_five_hundred_bodies_frees_all_resources(engine: str) -> None:
    client = Client("empty", engine=engine)
    come_and_go(client, 500, 100)
    gc.collect()
    before = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    for _ in range(3):
        come_and_go(client, 500, 10)
    grown = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    assert grown < 30_000, f"memory has grown by {grown} KB"


@pytest.mark.parametrize("engine", ENGINES)
def test_a_batch_spawns_all_valid_bodies(engine: str) -> None:
    client = Client("empty", engine=engine)
    wishes = (
        wish("first", 2.0, 0.0),
        wish("inside", 2.05, 0.0),
        wish("first", 3.0, 0.0),
        wish("wrong", 4.0, 0.0, "<sdf/>"),
        wish("robbed", 0.0, 0.0),
        wish("last", 5.0, 0.0),
    )
    answer = client.ask(wire.SPAWN_ENTITIES, wire.SpawnEntities(entities=wishes))
    assert [result.code for result in answer.results] == [
        Result.OK,
        SpawnResult.INVALID_POSE,
        SpawnResult.NAME_NOT_UNIQUE,
        SpawnResult.RESOURCE_PARSE_ERROR,
        SpawnResult.INVALID_POSE,
        Result.OK,
    ]
    assert "would overlap first" in answer.results[1].message
    assert "would overlap turtlebot4" in answer.results[4].message
    assert names(client) == ("first", "last", ROBOT)


def test_the_number_of_spawned_bodies_is_limited(empty: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sim_nodes.entities.MAX_SPAWNED", 3)
    answer = empty.ask(wire.SPAWN_ENTITIES, wire.SpawnEntities(entities=boxes(5)))
    assert [result.code == Result.OK for result in answer.results] == [True] * 3 + [False] * 2
    assert "too many spawned entities: 3" in answer.results[3].message

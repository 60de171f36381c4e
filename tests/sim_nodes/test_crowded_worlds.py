"""A generated world with rough ground, a door, people, a cart and robots repeats to the bit."""

from __future__ import annotations

import hashlib
from pathlib import Path

import pytest

from seoro.bridges import wire
from tests.sim_nodes.client import Client
from tests.sim_nodes.engines import MUJOCO_FIRST

ROBOTS = 4
HALFWAY, END = 2.01, 4.0  # [s]; a snapshot falls between two scans
WORLD = """
name: busy_office
generate:
  rooms: {size: [12, 8], count: 4, corridor: 1.8, door: 1.1}
  clutter: {fixed: 2, loose: 3}
robots:
  - {name: robot_1, robot: turtlebot4, pose: {x: -4.0, y: -0.4}}
  - {name: robot_2, robot: turtlebot4, pose: {x: -2.0, y: 0.4}}
  - {name: robot_3, robot: turtlebot4, pose: {x: 2.0, y: -0.4}}
  - {name: robot_4, robot: turtlebot4, pose: {x: 4.0, y: 0.4}}
crowds:
  - {name: visitors, count: 5, area: [-1.5, -0.8, 1.5, 0.8], speed: [0.5, 1.2], wander: [-5, -0.8, 5, 0.8]}
doors:
  - {name: gate, pose: {x: -3.0}, leaves: 2, width: 1.6, automatic: {range: 1.2, hold: 1.0}}
terrain:
  - {rough: {size: [2.0, 1.6], height: 0.01, spacing: 0.25}, center: [3.0, 0.0]}
carts:
  - {name: trolley, size: [0.5, 0.4, 0.6], pose: {x: 5.0}, speed: 0.4, path: {points: [[-5, 0]]}}
"""


def started(world: Path, engine: str) -> Client:
    """Return a client of the world whose robots are on their way to the other end of the corridor."""
    client = Client(str(world), 5, engine)
    for number in range(1, ROBOTS + 1):
        name = f"robot_{number}"
        at = client.simulator.simulation.frames.true_pose(name)
        here = wire.Pose3D(wire.Position3D(at.x, at.y), wire.Orientation3D(yaw=at.yaw))
        client.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot=name, pose=here))
        goal = wire.Pose3D(wire.Position3D(-at.x, -at.y))
        request = wire.NavigateThroughPoses(id=f"goal_{number}", robot=name, poses=(goal,))
        client.ask(wire.NAVIGATE_THROUGH_POSES, request)
    return client


def follow(client: Client, until: float) -> str:
    """Return a digest of all answers and states up to a time [s]."""
    digest = hashlib.sha256()
    time = client.simulator.simulation.time
    while time < until:
        advanced = client.advance(min(until, time + 0.25))
        time = advanced.time
        digest.update(wire.encode(advanced))
        for name in client.ask(wire.GET_ENTITIES, wire.EntityFilter()).names:
            digest.update(wire.encode(client.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=name))))
    return digest.hexdigest()


@pytest.mark.more
@pytest.mark.parametrize("engine", MUJOCO_FIRST)
def test_a_crowded_world_repeats_also_from_a_snapshot(engine: str, tmp_path: Path) -> None:
    world = tmp_path / "busy_office.yaml"
    world.write_text(WORLD)
    first, second = started(world, engine), started(world, engine)
    assert follow(first, HALFWAY) == follow(second, HALFWAY)
    answer = first.ask(wire.SAVE_STATE, wire.Empty())
    rest = follow(first, END)
    assert follow(second, END) == rest
    fork = Client("empty", 99, engine)
    request = wire.RestoreState(snapshot=answer, purpose=wire.Purpose.CONTINUE, seed=None)
    fork.ask(wire.RESTORE_STATE, request)
    assert follow(fork, END) == rest

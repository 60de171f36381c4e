"""Requests of a backend about the world of a simulator node."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges.launch import SimulatorOptions
from seoro.bridges.models import ModelPath
from seoro.bridges.sim.node import SimulatorNode
from seoro.bridges.wire import SpawnResult
from seoro.errors import BackendRefused
from seoro.robotics.geometry import Pose3D, Position3D
from tests.bridges.nodes import OPTIONS, Connect

WORLD = """
name: yard
extent: [-5, -5, 5, 5]
props:
  - {name: parcel, box: [0.2, 0.4, 0.6], mass: 2.0, pose: {x: 2.0, y: 0.0}}
"""


async def test_props_are_spawned_by_name_and_other_models_are_sent_to_the_node(
    mujoco: Connect, tmp_path: Path
) -> None:
    (tmp_path / "yard.yaml").write_text(WORLD)
    (tmp_path / "empty.sdf").write_text("")
    options = SimulatorOptions(str(tmp_path / "yard.yaml"), 3, ModelPath())
    async with mujoco(options)() as node:
        assert isinstance(node, SimulatorNode)
        there = Pose3D(Position3D(0.0, 1.0, 0.5))
        assert await node.spawn_entity("second", "prop://parcel", there) == "second"
        await node.spawn_entities([("third", "prop://parcel", Pose3D(Position3D(0.0, -1.0, 0.5)))])
        assert await node.entities() == ("parcel", "second", "third")
        for model, words in (
            ("prop://moon", "unknown prop 'moon' of the world; props: parcel"),
            (f"file://{tmp_path}/empty.sdf", "is empty"),
            ("none://none.sdf", "unknown model 'none://none.sdf'"),
        ):
            with pytest.raises(BackendRefused, match=words) as refused:
                await node.spawn_entity("fourth", model, there)
            assert refused.value.code == SpawnResult.NO_RESOURCE


async def test_a_run_continues_in_another_world_with_its_robots(mujoco: Connect) -> None:
    async with mujoco(OPTIONS)() as node:
        assert isinstance(node, SimulatorNode)
        assert node.assign_robot("robot", ("differential_drive_robot", "robot")) == "turtlebot4"
        now = await node.advance(1.0)
        with pytest.raises(BackendRefused, match="which lacks the differential_drive_robot 'turtlebot4'"):
            await node.change_world("arm_cell")
        await node.change_world("hall")
        assert [robot.name for robot in node.features.robots] == ["turtlebot4", "second"]
        assert await node.advance(now) == now
        await node.end_run()

"""An exposed simulator that a run on an executor drives."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

import seoro
from seoro.bridges import wire
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.embed.options import Ros
from tests.bridges.ros2.expose.exposed import exposed
from tests.executors import NAME, executor

pytestmark = [pytest.mark.engine("mujoco"), pytest.mark.more]

FALLING = Path(__file__).with_name("falling.osc")
WORKSHOP = Path(__file__).parents[4] / "examples/workshop/workshop.yaml"


async def test_an_executor_drives_the_simulator_in_an_uploaded_world(
    simulator: str, router: str, types: TypeStore, tmp_path: Path
) -> None:
    async with exposed(simulator, router, types) as node:
        with executor(tmp_path) as lab:
            async with seoro.Client(lab.endpoint) as client:
                of_ros = seoro.Simulator(name="ros", rate=math.inf, world=str(WORKSHOP))
                run = await client.submit(NAME, FALLING, simulator=of_ros, ros=Ros(router), seed=1)
                verdict = await run.result()
                missing = seoro.Simulator(name="ros", rate=math.inf, world="/opt/worlds/hall.sdf")
                refused = await client.submit(NAME, FALLING, simulator=missing, ros=Ros(router), seed=1)
                with pytest.raises(seoro.UsageError, match="worlds/hall"):
                    await refused.result()
        assert verdict.passed, verdict
        assert run.info.announcement == "seed 1, ros with world 'workshop'"
        names = (await node.ask(wire.GET_ENTITIES, wire.EntityFilter())).names
        assert "cart" in names
        assert "box" not in names

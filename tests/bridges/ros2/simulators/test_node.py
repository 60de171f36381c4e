"""A ROS 2 simulator as a simulator node: a simulator of seoro, used by its ROS services only."""

from __future__ import annotations

import math
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import pytest

import seoro
from seoro.bridges import wire
from seoro.bridges.launch import SimulatorOptions, connect_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.simulators.node import serving_simulator
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.bridges.session import open_session
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.bridges.wire.keys import NAMESPACE
from seoro.embed.options import Ros
from seoro.errors import BackendRefused, UsageError
from seoro.robotics.geometry import Pose3D, Position3D
from tests.bridges.ros2.expose.exposed import Exposed, exposed
from tests.sim_nodes.client import A, Q, pose

pytestmark = pytest.mark.engine("mujoco")

OPTIONS = SimulatorOptions(None, 3, ModelPath())
ROS_SIMULATOR = seoro.Simulator(name="ros", rate=math.inf)
BOX = "example_simulation://models/box.sdf"


class Bridged:
    """A simulator behind two bridges: endpoint of the second bridge, and the simulator."""

    def __init__(self, endpoint: str, simulator: Exposed) -> None:
        self.endpoint = endpoint
        self.simulator = simulator

    async def ask(self, verb: wire.Verb[Q, A], request: Q) -> A:
        """Send a request to the second bridge."""
        async with open_session(connect=self.endpoint) as session:
            return await ask(NodeAddress(session, NAMESPACE, "ros"), verb, request)


@asynccontextmanager
async def bridged(simulator: str, router: str, types: TypeStore, folder: Path) -> AsyncIterator[Bridged]:
    endpoint = f"unixsock-stream/{folder}/ros"
    async with (
        exposed(simulator, router, types) as node,
        connect(router, types=types, dialect=RmwZenoh()) as system,
        open_session(listen=endpoint, gossip=True) as hub,
        serving_simulator(hub, "ros", system),
    ):
        yield Bridged(endpoint, node)


async def test_a_run_controls_time_and_entities_of_the_simulator(
    simulator: str, router: str, types: TypeStore
) -> None:
    async with exposed(simulator, router, types) as node:
        scenario = seoro.load(Path(__file__).with_name("falling.osc"))
        async with seoro.start(scenario, simulator=ROS_SIMULATOR, ros=Ros(router), seed=1) as run:
            verdict = await run.result()
        assert verdict.passed, verdict
        ended = (await node.ask(wire.GET_SIMULATION_STATE, wire.Empty())).time
        assert ended == pytest.approx(1.54, abs=0.01)  # some steps were made to see how long they are
        assert "box" not in (await node.ask(wire.GET_ENTITIES, wire.EntityFilter())).names


async def test_grants_end_with_the_first_step_after_them(
    simulator: str, router: str, types: TypeStore, tmp_path: Path
) -> None:
    async with (
        bridged(simulator, router, types, tmp_path) as bridge,
        connect_simulator(bridge.endpoint, OPTIONS) as node,
    ):
        assert node.features.step == pytest.approx(0.004)
        assert await node.advance(0.003) == pytest.approx(0.004)
        assert await node.advance(0.02) == pytest.approx(0.02)
        began = (await bridge.simulator.ask(wire.GET_SIMULATION_STATE, wire.Empty())).time
        assert await node.advance(7.0) == pytest.approx(7.0)
        ended = (await bridge.simulator.ask(wire.GET_SIMULATION_STATE, wire.Empty())).time
        assert ended - began == pytest.approx(6.98)


async def test_entities_have_frames(simulator: str, router: str, types: TypeStore, tmp_path: Path) -> None:
    async with (
        bridged(simulator, router, types, tmp_path) as bridge,
        connect_simulator(bridge.endpoint, OPTIONS) as node,
    ):
        await node.spawn_entity("box", BOX, Pose3D(Position3D(1.0, 1.0, 0.2)))
        await node.ask(wire.SET_ENTITY_STATE, wire.SetEntityState(name="turtlebot4", pose=pose(1.0, -1.0, 1.5)))
        place = (await node.relative_pose("box", "turtlebot4_base_link_gt", 0.0)).position
        assert (place.x, place.y) == pytest.approx((2.0, 0.14), abs=0.02)


async def test_unsupported_requests_are_refused(
    simulator: str, router: str, types: TypeStore, tmp_path: Path
) -> None:
    async with bridged(simulator, router, types, tmp_path) as bridge:
        refused: tuple[tuple[wire.Verb[Any, Any], wire.Message, str], ...] = (
            (wire.SPAWN_ENTITY, wire.SpawnEntity(name="b", uri="no.sdf", initial_pose=pose(1.0, 1.0)), "no.sdf"),
            (wire.GET_ENTITY_STATE, wire.EntityName(name="moon"), "unknown entity 'moon' \\(entities: turtlebot4"),
            (wire.SAVE_STATE, wire.Empty(), "does not serve 'save_state'"),
            (wire.ADVANCE, wire.Advance(until=math.nan), "finite number"),
            (wire.GET_ENTITIES, wire.EntityFilter(categories=(1,)), "unsupported filter"),
        )
        for verb, request, words in refused:
            with pytest.raises(BackendRefused, match=words):
                await bridge.ask(verb, request)


async def test_a_system_without_a_simulator_is_reported(
    router: str, types: TypeStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.bridges.ros2.simulators.node.DISCOVERY_TIMEOUT", 0.1)
    async with connect(router, types=types, dialect=RmwZenoh()) as system:
        with pytest.raises(UsageError, match="no simulator with the services") as refused:
            async with serving_simulator(system.session, "ros", system):
                pass
        assert "step_simulation" in refused.value.help

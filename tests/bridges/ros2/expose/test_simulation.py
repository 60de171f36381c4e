from __future__ import annotations

from collections.abc import AsyncIterator, Mapping
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any

import anyio
import pytest

from seoro.bridges import wire
from seoro.bridges.ros2.clients.goals import sending_goal
from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.expose.node import ExposedNode
from seoro.bridges.ros2.expose.running import ExposeSettings, expose
from seoro.bridges.ros2.expose.simulation import FEATURES, SimulationServices
from seoro.bridges.ros2.geometry import seconds
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.services import simulation_service_type
from seoro.bridges.session import open_session
from seoro.bridges.sim.requests import NodeAddress
from seoro.bridges.sim.requests import ask as ask_node
from seoro.bridges.wire.keys import NAMESPACE
from seoro.errors import BackendRefused
from seoro.runtime.contracts.backends import GoalStatus
from tests.bridges.ros2.expose.exposed import STARTED_WITHIN, Exposed, exposed, first, under_way
from tests.sim_nodes.client import BOX

pytestmark = pytest.mark.engine("mujoco")

OK, UNSUPPORTED, NOT_FOUND, FAILED = 1, 0, 2, 4
STOPPED, PLAYING, PAUSED, QUITTING, NO_WORLD = range(5)


class Services:
    """A client of the services of a simulator."""

    def __init__(self, node: Exposed, stack: AsyncExitStack) -> None:
        self.node = node
        self._stack = stack

    async def __call__(self, name: str, request: Mapping[str, Any] | None = None) -> Any:
        kind = "".join(word.capitalize() for word in name.split("_"))
        client = await self._stack.enter_async_context(
            self.node.ros.calling(f"/{name}", f"simulation_interfaces/srv/{kind}")
        )
        await client.wait_for_server(30.0)
        return await client.call(request or {}, 20.0)


@asynccontextmanager
async def simulating(
    simulator: str, router: str, types: TypeStore, world: str, **settings: Any
) -> AsyncIterator[Services]:
    async with (
        exposed(simulator, router, types, world, **settings) as node,
        AsyncExitStack() as stack,
    ):
        yield Services(node, stack)


def at(x: float, y: float, z: float = 0.1, frame: str = "map") -> dict[str, Any]:
    return {
        "header": {"frame_id": frame},
        "pose": {"position": {"x": x, "y": y, "z": z}, "orientation": {"w": 1.0}},
    }


def spawning(name: str, pose: dict[str, Any], **more: Any) -> dict[str, Any]:
    return {"name": name, "entity_resource": {"resource_string": BOX}, "initial_pose": pose, **more}


async def test_entities_are_spawned_found_moved_and_deleted(simulator: str, router: str, types: TypeStore) -> None:
    async with simulating(simulator, router, types, "maze") as call:
        features = (await call("get_simulator_features")).features
        assert {0, 1, 9, 10, 11, 20, 25, 31, 33, 40, 50} <= set(features.features.tolist())
        assert "sdf" in features.spawn_formats
        spawned = await call("spawn_entity", spawning("box", at(1.0, 0.5)))
        assert (spawned.result.result, spawned.entity_name) == (OK, "box")
        again = await call("spawn_entity", spawning("box", at(1.0, 0.5)))
        assert (again.result.result, again.entity_name) == (101, "")
        assert "box" in again.result.error_message
        renamed = await call("spawn_entity", spawning("box", at(1.0, -0.5), allow_renaming=True))
        assert renamed.entity_name not in ("", "box")
        for wrong, code in (
            (spawning("b", at(0.0, 0.0, frame="odom")), 109),
            (spawning("b", {"pose": {"orientation": {"w": 0.0}}}), 109),
            (spawning("b", at(1.0, 1.0), entity_namespace="/b"), 105),
            ({"name": "b", "entity_resource": {"uri": "nothing.sdf"}, "initial_pose": at(1.0, 1.0)}, 104),
        ):
            assert (await call("spawn_entity", wrong)).result.result == code
        many = await call(
            "spawn_entities", {"spawn_requests": [spawning("c", at(0.5, 1.5)), spawning("box", at(0, 0))]}
        )
        assert (many.result.result, [each.result.result for each in many.results]) == (150, [OK, 101])
        found = await call("get_entities", {"filters": {"filter": "b.*|c"}})
        assert list(found.entities) == sorted(["box", "c", renamed.entity_name])
        box = {"type": 1, "points": [{"x": 2.0, "y": 1.0, "z": 1.0}, {"x": 0.8, "y": 0.0, "z": 0.0}]}
        assert list((await call("get_entities", {"filters": {"bounds": box}})).entities) == ["box"]
        sphere = await call("get_entities", {"filters": {"bounds": {"type": 3}}})
        assert sphere.result.result == UNSUPPORTED
        state = {"pose": at(1.2, 0.4)["pose"]}
        moved = await call("set_entity_state", {"entity": "box", "state": state, "set_pose": True})
        assert moved.result.result == OK
        got = (await call("get_entity_state", {"entity": "box"})).state
        assert (got.pose.position.x, got.pose.position.y) == pytest.approx((1.2, 0.4))
        assert got.header.frame_id == "map"
        states = await call("get_entities_states", {"filters": {"filter": "box"}})
        assert states.states[0].pose.position.x == pytest.approx(1.2)
        bounds = (await call("get_entity_bounds", {"entity": "box"})).bounds
        assert bounds.type == 1
        assert bounds.points[0].z > bounds.points[1].z
        info = {"category": {"category": 4}, "description": "a box", "tags": ["red"]}
        assert (await call("set_entity_info", {"entity": "box", "info": info})).result.result == OK
        reported = (await call("get_entity_info", {"entity": "box"})).info
        assert (reported.category.category, reported.description, list(reported.tags)) == (4, "a box", ["red"])
        assert (await call("delete_entity", {"entity": "box"})).result.result == OK
        gone = await call("get_entity_state", {"entity": "box"})
        assert gone.result.result == NOT_FOUND
        assert "box" in gone.result.error_message


async def test_services_control_the_time_and_the_world(simulator: str, router: str, types: TypeStore) -> None:
    async with (
        simulating(simulator, router, types, "empty") as call,
        call.node.ros.subscribing("/clock", "rosgraph_msgs/msg/Clock") as clock,
    ):
        assert (await call("get_simulation_state")).state.state == STOPPED
        assert (await call("step_simulation", {"steps": 25})).result.result == OK
        assert [seconds(each.clock) for each in await first(clock, 5)] == pytest.approx(
            [0.02, 0.04, 0.06, 0.08, 0.1]
        )
        assert (await call("step_simulation", {"steps": 0})).result.result == FAILED
        for wanted, result in (
            (PLAYING, OK),
            (PLAYING, 101),
            (PAUSED, OK),
            (QUITTING, UNSUPPORTED),
            (9, UNSUPPORTED),
        ):
            answer = await call("set_simulation_state", {"state": {"state": wanted}})
            assert (wanted, answer.result.result) == (wanted, result)
        assert (await call("get_simulation_state")).state.state == PAUSED
        assert (await call("reset_simulation", {"scope": 0})).result.result == OK
        assert (await call("reset_simulation", {"scope": 64})).result.result == FAILED
        names = [world.name for world in (await call("get_available_worlds")).worlds]
        assert "maze" in names
        missing = await call("load_world", {"world_resource": {"uri": "moon"}})
        assert missing.result.result == 102
        loaded = await call("load_world", {"world_resource": {"uri": "arm_cell"}})
        assert (loaded.result.result, loaded.world.name) == (OK, "arm_cell")
        joints = call.node.ros.subscribing("/ur10e/joint_states", "sensor_msgs/msg/JointState")
        async with joints as arm:
            await call.node.ros.graph.wait_for(lambda graph: graph.publishers("/ur10e/joint_states"), 30.0)
            assert not call.node.ros.graph.publishers("/turtlebot4/scan")
            await call("step_simulation", {"steps": 10})
            assert len((await first(arm))[0].name) == 8
        assert (await call("get_current_world")).world.world_resource.uri == "arm_cell"
        assert (await call("unload_world")).result.result == OK
        assert (await call("get_simulation_state")).state.state == NO_WORLD
        assert (await call("get_current_world")).result.result == 101
        assert (await call("unload_world")).result.result == 101


async def test_a_world_without_the_robot_of_the_root_namespace_keeps_the_node_alive(
    simulator: str, router: str, types: TypeStore, caplog: pytest.LogCaptureFixture
) -> None:
    async with simulating(simulator, router, types, "empty", root="turtlebot4") as call:
        graph = call.node.ros.graph
        await graph.wait_for(lambda graph: graph.publishers("/scan"), 30.0)
        assert (await call("unload_world")).result.result == OK
        await graph.wait_for(lambda graph: not graph.publishers("/scan"), 30.0)
        assert "unknown robot 'turtlebot4'; robots of no world: none" in caplog.text
        assert (await call("load_world", {"world_resource": {"uri": "empty"}})).result.result == OK
        await graph.wait_for(lambda graph: graph.publishers("/scan"), 30.0)


async def test_steps_are_simulated_and_canceled(simulator: str, router: str, types: TypeStore) -> None:
    action, kind = "/simulate_steps", "simulation_interfaces/action/SimulateSteps"
    reported: list[Members] = []
    async with exposed(simulator, router, types) as node:
        async with sending_goal(node.ros, action, kind, {"steps": 120}, reported.append) as goal:
            ended = await goal.ended()
            assert (ended.status, ended.result["result"]["result"]) == (GoalStatus.SUCCEEDED, OK)
        assert [each["completed_steps"] for each in reported] == [50, 100, 120]
        assert (await node.ask(wire.GET_SIMULATION_STATE, wire.Empty())).time == pytest.approx(0.48)
        async with sending_goal(node.ros, action, kind, {"steps": 10**9}, reported.append) as goal:
            await goal.cancel()
            assert (await goal.ended()).status is GoalStatus.CANCELED
        playing = wire.SetSimulationState(state=wire.SimulationState.PLAYING)
        await node.ask(wire.SET_SIMULATION_STATE, playing)
        async with sending_goal(node.ros, action, kind, {"steps": 1}, reported.append) as goal:
            ended = await goal.ended()
            assert (ended.status, ended.result["result"]["result"]) == (GoalStatus.ABORTED, 3)


def test_all_services_of_simulation_interfaces_are_served(types: TypeStore) -> None:
    services = {name for name in types.names() if name.startswith("simulation_interfaces/srv/")}
    served = SimulationServices(None).all()  # type: ignore[arg-type]
    assert set(map(simulation_service_type, served)) == services
    assert FEATURES.keys() <= {verb.name for verb in wire.VERBS}


async def test_changes_by_other_clients_of_the_simulator_are_published(
    simulator: str, router: str, types: TypeStore
) -> None:
    async with exposed(simulator, router, types, "maze") as node:
        await node.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot="turtlebot4", pose=wire.Pose3D()))
        await node.ask(wire.STEP_SIMULATION, wire.StepSimulation(steps=100))
        far = {"pose": {"pose": {"position": {"x": 3.0, "y": -3.0}, "orientation": {"w": 1.0}}}}
        action = ("/turtlebot4/navigate_to_pose", "nav2_msgs/action/NavigateToPose")
        async with sending_goal(node.ros, *action, far, lambda _: None) as goal:
            await under_way(node)
            await node.ask(wire.LOAD_WORLD, wire.LoadWorld(world="arm_cell"))
            ended = await goal.ended()
            assert (ended.status, ended.result["error_msg"]) == (
                GoalStatus.ABORTED,
                "the simulation was started over",
            )
        await node.ros.graph.wait_for(lambda graph: graph.publishers("/ur10e/joint_states"), 30.0)
        await node.ros.graph.wait_for(lambda graph: not graph.publishers("/turtlebot4/scan"), 30.0)


async def test_worlds_loaded_by_other_clients_are_exposed_at_any_time(
    simulator: str, router: str, types: TypeStore
) -> None:
    async with exposed(simulator, router, types, "empty") as node:
        await node.ask(wire.LOAD_WORLD, wire.LoadWorld(world="arm_cell"))  # at the beginning, as before
        await node.ros.graph.wait_for(lambda graph: graph.publishers("/ur10e/joint_states"), 30.0)
        await node.ros.graph.wait_for(lambda graph: not graph.publishers("/turtlebot4/scan"), 30.0)
        await node.ask(wire.UNLOAD_WORLD, wire.Empty())
        await node.ros.graph.wait_for(lambda graph: not graph.publishers("/ur10e/joint_states"), 30.0)
        await node.ask(wire.LOAD_WORLD, wire.LoadWorld(world="empty"))
        await node.ros.graph.wait_for(lambda graph: graph.publishers("/turtlebot4/scan"), 30.0)
        assert not node.ros.graph.publishers("/ur10e/joint_states")


async def test_a_world_loaded_while_robots_are_being_exposed_is_exposed(
    simulator: str, router: str, types: TypeStore, monkeypatch: pytest.MonkeyPatch
) -> None:
    ask = ExposedNode.ask
    meddled: list[wire.SimulatorFeatures] = []

    async def meddle(self: ExposedNode, verb: wire.Verb[wire.Q, wire.A], request: wire.Q) -> wire.A:
        if verb is wire.GET_ROBOT_DESCRIPTION and not meddled:
            meddled.append(await ask(self, wire.LOAD_WORLD, wire.LoadWorld(world="arm_cell")))
        return await ask(self, verb, request)

    monkeypatch.setattr(ExposedNode, "ask", meddle)
    async with exposed(simulator, router, types, "empty") as node:
        await node.ros.graph.wait_for(lambda graph: graph.publishers("/ur10e/joint_states"), 30.0)
        assert not node.ros.graph.publishers("/turtlebot4/scan")


async def test_a_refusal_within_an_unchanged_world_ends_the_exposure(
    simulator: str, router: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    ask = ExposedNode.ask

    async def refuse(self: ExposedNode, verb: wire.Verb[wire.Q, wire.A], request: wire.Q) -> wire.A:
        if verb is wire.GET_ROBOT_DESCRIPTION:
            raise BackendRefused("robots are not described", wire.Result.FEATURE_UNSUPPORTED)
        return await ask(self, verb, request)

    async with open_session(connect=simulator) as session:
        await ask_node(NodeAddress(session, NAMESPACE, "sim"), wire.LOAD_WORLD, wire.LoadWorld(world="empty"))
    monkeypatch.setattr(ExposedNode, "ask", refuse)
    with anyio.fail_after(STARTED_WITHIN), pytest.raises(BackendRefused, match="not described"):
        await expose(ExposeSettings(simulator, router), lambda _: None)

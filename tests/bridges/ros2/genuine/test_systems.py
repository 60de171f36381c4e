"""Names, domains, clocks, frames and life of genuine nodes."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Any

import anyio
import pytest

import seoro
from seoro.bridges.ros2.clients.lifecycle import GONE, watching_lifecycle
from seoro.bridges.ros2.interfaces.messages import plain
from seoro.bridges.ros2.participant import connect
from seoro.bridges.ros2.state.publishing import BEHAVIORS
from seoro.bridges.ros2.state.stopping import STOP, TRIGGER
from seoro.bridges.ros2.tf.listener import listen
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.embed import prepare
from seoro.embed.options import Options, Ros
from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2, running
from tests.bridges.ros2.genuine.steering import own_node, steered

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

STRING, TF = "std_msgs/msg/String", "tf2_msgs/msg/TFMessage"
LATCHED = {"durability": "transient_local", "depth": 1}


def frame(parent: str, child: str, x: float, second: int = 0) -> dict[str, Any]:
    header = {"stamp": {"sec": second, "nanosec": 0}, "frame_id": parent}
    transform = {"translation": {"x": x, "y": 0.0, "z": 0.0}, "rotation": {"x": 0.0, "y": 0.0, "z": 0.0, "w": 1.0}}
    return {"transforms": [{"header": header, "child_frame_id": child, "transform": transform}]}


async def test_remapped_names_are_those_of_the_graph(ros2: Ros2, router: str) -> None:
    remap = ("--ros-args", "-r", "__ns:=/bot1", "-r", "__node:=robot", "-r", "chatter:=/talk")
    async with steered(ros2, router, "any", *remap) as genuine, own_node(router) as own:
        await genuine.ask("publisher", topic="chatter", type=STRING, **LATCHED)
        [found] = await own.graph.wait_for(lambda graph: graph.publishers("/talk"), DEADLINE)
        assert "/bot1/robot" in own.graph.nodes()
        assert found.type == STRING
        names = (await genuine.ask("graph"))["nodes"]
        assert {"/bot1/robot", "/seoro"} <= set(names)


async def test_domains_do_not_see_each_other(ros2: Ros2, router: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "5")
    async with steered(ros2, router) as genuine:
        await genuine.ask("publisher", topic="/five", type=STRING, **LATCHED)
        await genuine.ask("publish", topic="/five", messages=[{"data": "five"}])
        async with connect(router, dialect=RmwZenoh(domain=5)) as system, system.node("seoro") as own:
            await own.graph.wait_for(lambda graph: graph.publishers("/five"), DEADLINE)
        async with own_node(router) as own:
            assert "/steered" not in own.graph.nodes()
            assert "/seoro" in own.graph.nodes()


async def test_frames_of_genuine_nodes_are_followed(ros2: Ros2, router: str) -> None:
    async with steered(ros2, router) as genuine, own_node(router) as own:
        await genuine.ask("publisher", topic="/tf_static", type=TF, **LATCHED)
        await genuine.ask("publish", topic="/tf_static", messages=[frame("base_link", "laser", 0.25)])
        await genuine.ask("publisher", topic="/tf", type=TF, depth=100)
        async with listen(own, "") as listener:
            with anyio.fail_after(DEADLINE):
                while (await genuine.ask("matched", topic="/tf"))["subscriptions"] < 1:
                    await anyio.sleep(0.05)
            moving = [frame("odom", "base_link", second / 10, second) for second in range(1, 21)]
            await genuine.ask("publish", topic="/tf", messages=moving)
            with anyio.fail_after(DEADLINE):
                await listener.wait_for(
                    lambda buffer: (
                        (found := buffer.find("laser", "odom")) is not None
                        and found.transform.translation[0] == pytest.approx(2.25)
                    )
                )


async def test_genuine_nodes_receive_frames(ros2: Ros2, router: str) -> None:
    async with steered(ros2, router) as genuine, own_node(router) as own:
        await genuine.ask("subscribe", topic="/tf", type=TF, depth=100)
        async with own.publishing("/tf", TF) as publication:
            with anyio.fail_after(DEADLINE):
                await publication.wait_for_subscription()
            publication.publish(frame("map", "odom", 0.5, 3))
            received = await genuine.event("message", topic="/tf")
        assert received["message"] == frame("map", "odom", 0.5, 3)


async def test_simulated_time_reaches_genuine_nodes(ros2: Ros2, router: str) -> None:
    clock = "rosgraph_msgs/msg/Clock"
    async with steered(ros2, router) as genuine, own_node(router) as own:
        await genuine.ask("use_sim_time")
        async with own.publishing("/clock", clock) as publication:
            with anyio.fail_after(DEADLINE):
                await publication.wait_for_subscription()
                for second in (100, 200):
                    publication.publish({"clock": {"sec": second, "nanosec": 5}})
                    while await genuine.ask("time") != second * 10**9 + 5:
                        await anyio.sleep(0.02)
        assert time.time() > 1e9  # of the machine


async def test_states_of_a_genuine_lifecycle_node_are_followed(ros2: Ros2, router: str) -> None:
    change = "lifecycle_msgs/srv/ChangeState"
    async with (
        steered(ros2, router, "life") as genuine,
        own_node(router) as own,
        watching_lifecycle(own, "/life") as states,
        own.calling("/life/change_state", change) as client,
    ):
        with anyio.fail_after(DEADLINE):
            await client.wait_for_server()
            assert await anext(states) == "unconfigured"
            assert plain(await client.call({"transition": {"id": 1}})) == {"success": True}
            assert await _reached(states, "inactive")
            await client.call({"transition": {"id": 3}})
            assert await _reached(states, "active")
            genuine.process.kill()
            assert await _reached(states, GONE)


async def _reached(states: Any, wanted: str) -> bool:
    async for state in states:
        if state == wanted:
            return True
    return False


async def test_killed_nodes_of_seoro_leave_the_graph_of_genuine_nodes(ros2: Ros2, router: str) -> None:
    async with steered(ros2, router) as genuine:
        async with own_node(router, name="mortal"):
            with anyio.fail_after(DEADLINE):
                while "/mortal" not in (await genuine.ask("graph"))["nodes"]:
                    await anyio.sleep(0.05)
        with anyio.fail_after(DEADLINE):
            while "/mortal" in (await genuine.ask("graph"))["nodes"]:
                await anyio.sleep(0.05)


async def test_genuine_nodes_see_the_state_of_a_run(ros2: Ros2, router: str, tmp_path: Path) -> None:
    file = tmp_path / "waits.osc"
    file.write_text("import osc.helpers\nscenario waits:\n    do wait elapsed(600s)\n")
    topic = {"topic": BEHAVIORS, "type": "diagnostic_msgs/msg/DiagnosticArray"}
    command = [sys.executable, "-m", "seoro", "exec", str(file), "--ros", router]
    async with (
        steered(ros2, router) as genuine,
        running(command, "seed"),
    ):
        await genuine.ask("subscribe", **topic, **LATCHED)
        seen: dict[str, str] = {}
        while seen.get("seoro/waits/wait[0]") != "running":
            message = (await genuine.event("message", topic=BEHAVIORS))["message"]
            seen = {each["name"]: each["message"] for each in message["status"]}
        assert seen["seoro"] == "running"


async def test_genuine_nodes_stop_all_runs_of_a_system(ros2: Ros2, router: str, tmp_path: Path) -> None:
    file = tmp_path / "waits.osc"
    file.write_text("import osc.helpers\nscenario waits:\n    do wait elapsed(600s)\n")
    scenario, options = seoro.load(file), Options(ros=Ros(router, dialect="rmw_zenoh"))
    async with (
        steered(ros2, router) as genuine,
        own_node(router) as own,
        prepare(scenario, options) as first,
        prepare(scenario, options) as second,
        first.running(),
        second.running(),
    ):
        with anyio.fail_after(DEADLINE):
            await own.graph.wait_for(lambda graph: len(graph.servers(STOP)) == 2)
            for run in (first, second):
                async for record in run.trace():
                    if record["kind"] == "behavior.start" and record["type"] == "wait":
                        break
            [answer] = await genuine.ask("call", service=STOP, type=TRIGGER, requests=[{}])
            assert answer == {"success": True, "message": "the run stops its robots and cleans up"}
            for run in (first, second):
                verdict = await run.result()
                assert (verdict.status.value, verdict.reason) == ("cancelled", f"stopped by the service {STOP}")

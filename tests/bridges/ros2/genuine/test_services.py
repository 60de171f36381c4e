"""Services and parameters between seoro and genuine nodes, in both roles."""

from __future__ import annotations

import asyncio
from collections.abc import Mapping
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.clients.parameters import get_parameters, list_parameters, set_parameter
from seoro.bridges.ros2.errors import CallFailed, WrongType
from seoro.bridges.ros2.interfaces.messages import plain
from seoro.errors import SeoroError
from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2
from tests.bridges.ros2.genuine.steering import own_node, steered

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

SET_BOOL, TRIGGER = "std_srvs/srv/SetBool", "std_srvs/srv/Trigger"


async def test_genuine_servers_answer(ros2: Ros2, router: str) -> None:
    async with steered(ros2, router) as genuine, own_node(router) as own:
        await genuine.ask(
            "serve", service="/enable", type=SET_BOOL, response={"success": True, "message": "grüße"}
        )
        await genuine.ask("serve", service="/slow", type=TRIGGER, delay=2.0, response={"message": "slow"})
        async with own.calling("/enable", SET_BOOL) as client:
            await client.wait_for_server(DEADLINE)
            assert plain(await client.call({"data": True}, DEADLINE)) == {"success": True, "message": "grüße"}
            assert (await genuine.event("request"))["request"] == {"data": True}
        async with own.calling("/slow", TRIGGER) as client:
            await client.wait_for_server(DEADLINE)
            assert (await client.call({}, DEADLINE)).message == "slow"


async def test_the_end_of_a_genuine_server_ends_its_calls(ros2: Ros2, router: str) -> None:
    async with steered(ros2, router) as genuine, own_node(router) as own:
        await genuine.ask("serve", service="/never", type=TRIGGER, delay=600.0)
        async with own.calling("/never", TRIGGER) as client:
            await client.wait_for_server(DEADLINE)
            call = asyncio.create_task(client.call({}, DEADLINE))
            await genuine.event("request")
            genuine.process.kill()
            with pytest.raises(CallFailed, match="server of /never"):
                await call


async def test_genuine_clients_are_answered(ros2: Ros2, router: str) -> None:
    async def enable(request: Any) -> Mapping[str, Any]:
        return {"success": request.data, "message": "on" if request.data else "off"}

    async with steered(ros2, router) as genuine, own_node(router) as own:
        async with own.serving("/enable", SET_BOOL, enable):
            asked = [{"data": number % 2 == 0} for number in range(8)]  # rmw_zenoh keeps 10 at a time
            found = await genuine.ask("call", service="/enable", type=SET_BOOL, requests=asked)
        assert [(each["success"], each["message"]) for each in found] == [(True, "on"), (False, "off")] * 4


async def test_services_of_another_type_are_refused(ros2: Ros2, router: str) -> None:
    async with steered(ros2, router) as genuine, own_node(router) as own:
        await genuine.ask("serve", service="/enable", type=TRIGGER)
        async with own.calling("/enable", SET_BOOL) as client:
            await client.wait_for_server(DEADLINE)
            with pytest.raises(WrongType, match="std_srvs/srv/Trigger, not std_srvs/srv/SetBool"):
                await client.call({}, DEADLINE)
        await genuine.ask("publisher", topic="/wrong", type="std_msgs/msg/Int32")
        await own.graph.wait_for(lambda graph: graph.publishers("/wrong"), DEADLINE)
        with pytest.raises(WrongType, match="/wrong is of type std_msgs/msg/Int32"):
            async with own.subscribing("/wrong", "std_msgs/msg/String"):
                pass


async def test_parameters_of_genuine_nodes_are_read_and_set(ros2: Ros2, router: str) -> None:
    async with steered(ros2, router) as genuine, own_node(router) as own:
        await genuine.ask("declare", name="speed", value=0.5, low=0.0, high=2.0)
        await genuine.ask("declare", name="mode", value="slow", refused="wild")
        await genuine.ask("declare", name="fixed", value=7, read_only=True)
        await genuine.ask("declare", name="flags", value=[True, False])
        assert {"speed", "mode", "fixed", "flags"} <= set(await list_parameters(own, "/steered"))
        found = await get_parameters(own, "/steered", ["speed", "mode", "fixed", "flags"])
        assert found == {"speed": 0.5, "mode": "slow", "fixed": 7, "flags": [True, False]}
        for name, text, value in (("speed", "1", 1.0), ("mode", "fast", "fast"), ("flags", "[false]", [False])):
            await set_parameter(own, "/steered", name, text)
            assert await genuine.ask("parameter", name=name) == value
        for name, text, reason in (
            ("speed", "5.0", "out of range|range"),
            ("mode", "wild", "mode is refused here"),
            ("fixed", "8", "read-only|read only"),
            ("unknown", "1", "unknown|declared"),
        ):
            with pytest.raises(SeoroError, match=reason):
                await set_parameter(own, "/steered", name, text)
        assert await genuine.ask("parameter", name="fixed") == 7


async def test_events_of_parameters_are_received(ros2: Ros2, router: str) -> None:
    events = "rcl_interfaces/msg/ParameterEvent"
    async with steered(ros2, router) as genuine, own_node(router) as own:
        await genuine.ask("declare", name="speed", value=0.5)
        async with own.subscribing("/parameter_events", events) as subscription:
            with anyio.fail_after(DEADLINE):
                while (await genuine.ask("matched", topic="/parameter_events"))["subscriptions"] < 1:
                    await anyio.sleep(0.05)
                await set_parameter(own, "/steered", "speed", "0.75")
                event = plain(subscription.decode(await subscription.receive()))
        assert event["node"] == "/steered"
        assert [(each["name"], each["value"]["double_value"]) for each in event["changed_parameters"]] == [
            ("speed", 0.75)
        ]

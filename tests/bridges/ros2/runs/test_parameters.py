"""Parameters that a node of seoro serves."""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.interfaces.messages import plain
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.runs.parameters import EVENTS, TextParameters, serving_parameters
from tests.bridges.ros2.systems import two_nodes

pytestmark = pytest.mark.anyio

DEADLINE = 60.0  # [s]
STRING, INTEGER = 4, 2
NAMES = {"scenario": "file", "parameters": "values"}


class Asking:
    """A node that calls the services of another one."""

    def __init__(self, node: RosNode, parameters: TextParameters) -> None:
        self.node = node
        self.parameters = parameters

    async def ask(self, service: str, type_name: str, **request: Any) -> Any:
        async with self.node.calling(f"/robot/{service}", f"rcl_interfaces/srv/{type_name}") as client:
            await client.wait_for_server(DEADLINE)
            return plain(await client.call(request, DEADLINE))


@asynccontextmanager
async def asking_robot(router: str, types: TypeStore) -> AsyncIterator[Asking]:
    async with two_nodes(router, types) as (there, here), serving_parameters(there, NAMES) as parameters:
        yield Asking(here, parameters)


def value(name: str, text: str) -> dict[str, Any]:
    return {"name": name, "value": {"type": STRING, "string_value": text}}


async def test_parameters_are_listed_and_described(router: str, types: TypeStore) -> None:
    async with asking_robot(router, types) as asking:
        for prefixes, names in (([], ["scenario", "parameters"]), (["scenario"], ["scenario"]), (["scen"], [])):
            found = await asking.ask("list_parameters", "ListParameters", prefixes=prefixes)
            assert found["result"]["names"] == names
        found = await asking.ask("describe_parameters", "DescribeParameters", names=["scenario"])
        [described] = found["descriptors"]
        assert (described["name"], described["type"], described["description"]) == ("scenario", STRING, "file")
        found = await asking.ask("get_parameter_types", "GetParameterTypes", names=["scenario", "other"])
        assert list(found["types"]) == [STRING, 0]
        found = await asking.ask("get_parameters", "GetParameters", names=["scenario", "other"])
        assert found["values"] == []  # as of nodes of rclcpp and rclpy


async def test_changes_are_published(router: str, types: TypeStore) -> None:
    async with asking_robot(router, types) as asking:
        async with asking.node.subscribing(EVENTS, "rcl_interfaces/msg/ParameterEvent") as events:
            with anyio.fail_after(DEADLINE):
                while not asking.node.graph.publishers(EVENTS):
                    await anyio.sleep(0.01)
                await asking.parameters.events.wait_for_subscription(DEADLINE)
                await asking.ask("set_parameters", "SetParameters", parameters=[value("scenario", "a.osc")])
                event = await events.message()
        assert event.node == "/robot"
        assert [(each.name, each.value.string_value) for each in event.changed_parameters] == [
            ("scenario", "a.osc")
        ]


async def test_all_parameters_or_none_are_set_atomically(router: str, types: TypeStore) -> None:
    async with asking_robot(router, types) as asking:
        wrong = {"name": "scenario", "value": {"type": INTEGER, "integer_value": 1}}
        for bad, reason in ((wrong, "is a text"), (value("other", "x"), "unknown parameter `other`")):
            both = [value("parameters", "{}"), bad]
            found = await asking.ask("set_parameters_atomically", "SetParametersAtomically", parameters=both)
            assert not found["result"]["successful"]
            assert reason in found["result"]["reason"]
            assert asking.parameters.text("parameters") == ""
        both = [value("parameters", "{}"), wrong]
        found = await asking.ask("set_parameters", "SetParameters", parameters=both)
        assert [each["successful"] for each in found["results"]] == [True, False]
        found = await asking.ask("set_parameters_atomically", "SetParametersAtomically", parameters=both[:1])
        assert found["result"]["successful"]
        assert asking.parameters.values == {"parameters": "{}"}

"""Definitions fetched from robots, over real sessions and a router."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.descriptions import SERVICE, decode_message, node_for_service
from seoro.bridges.ros2.errors import DefinitionMismatch
from seoro.bridges.ros2.interfaces import Message, TypeStore, UnknownInterface
from seoro.bridges.ros2.interfaces.type_descriptions import described
from tests.bridges.ros2.systems import STRING, two_nodes, with_another_string

STATE = "own_msgs/msg/State"
DEFINITION = """\
uint8 IDLE=3
std_msgs/Header header
Part[] parts
string<=20 name "unnamed"
float32[3] place
int64[<=4] numbers
byte[] raw
bool is_well true
"""
VALUE = {
    "header": {"frame_id": "map", "stamp": {"sec": 7}},
    "parts": [{"voltage": 1.5}, {}],
    "name": "arm",
    "place": [1.0, 2.0, 3.0],
    "numbers": [-5, 2**40],
    "raw": b"\x01\xff",
    "is_well": True,
}


def own_types(types: TypeStore, folder: Path) -> TypeStore:
    """Return the definitions with those of a package of the robot."""
    package = folder / "own_msgs" / "msg"
    package.mkdir(parents=True)
    (package / "State.msg").write_text(DEFINITION)
    (package / "Part.msg").write_text("float64 voltage\nEmpty nothing\n")
    (package / "Empty.msg").write_text("")
    return types.add_folder(folder)


class Describer:
    """Server of type definitions that counts requests."""

    def __init__(self, types: TypeStore) -> None:
        self._types = types
        self.asked = 0

    async def describe(self, request: Message) -> Mapping[str, Any]:
        self.asked += 1
        if self._types.type_hash(request.type_name) != request.type_hash:
            return {"successful": False, "failure_reason": "another hash"}
        description = described(request.type_name, self._types.structure)
        return {"successful": True, "type_description": description}


class Liar(Describer):
    """A server of descriptions that sends another type."""

    async def describe(self, request: Message) -> Mapping[str, Any]:
        self.asked += 1
        return {"successful": True, "type_description": described("std_msgs/msg/Int8", self._types.structure)}


async def received(
    router: str, types: TypeStore, theirs: TypeStore, describer: Describer, type_name: str
) -> list[Message]:
    """Return two messages of a robot that serves its definitions."""
    value = VALUE if type_name == STATE else {"data": "hello", "priority": 3}
    async with (
        two_nodes(router, types, theirs=theirs) as (there, here),
        there.serving("~/get_type_description", SERVICE, describer.describe),
        there.publishing("/state", type_name) as publication,
    ):
        with anyio.fail_after(30.0):
            await here.graph.wait_for(
                lambda seen: seen.publishers("/state") and seen.servers("/robot/get_type_description")
            )
            async with here.subscribing("/state", type_name) as subscription:
                await publication.wait_for_subscription()
                publication.publish(value)
                publication.publish(value)
                return [await decode_message(here, subscription, await subscription.receive()) for _ in range(2)]


async def test_a_type_defined_only_by_the_robot_is_requested_once(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    theirs = own_types(types, tmp_path)
    describer = Describer(theirs)
    first, second = await received(router, types, theirs, describer, STATE)
    assert theirs.encode(STATE, VALUE) == theirs.encode(STATE, theirs.plain(STATE, first))
    assert (first.header.frame_id, first.parts[0].voltage, first.name) == ("map", 1.5, "arm")
    assert first == second
    assert describer.asked == 1


async def test_another_definition_of_a_known_type_is_requested(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    theirs = with_another_string(types, tmp_path)
    message, _ = await received(router, types, theirs, Describer(theirs), STRING)
    assert (message.data, message.priority) == ("hello", 3)


@pytest.mark.parametrize("make", [Liar, lambda types: Describer(TypeStore.bundled())])
async def test_a_definition_with_a_wrong_hash_is_refused(
    make: Any, router: str, types: TypeStore, tmp_path: Path, caplog: pytest.LogCaptureFixture
) -> None:
    theirs = with_another_string(types, tmp_path)
    describer = make(types)
    with pytest.raises(DefinitionMismatch):
        await received(router, types, theirs, describer, STRING)
    assert describer.asked == 1
    assert len(caplog.messages) == isinstance(describer, Liar)


async def test_a_type_without_a_description_server_is_unknown(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    theirs = own_types(types, tmp_path)
    async with (
        two_nodes(router, types, theirs=theirs) as (there, here),
        there.publishing("/state", STATE) as publication,
    ):
        with anyio.fail_after(30.0):
            await here.graph.wait_for(lambda seen: seen.publishers("/state"))
            async with here.subscribing("/state", STATE) as subscription:
                await publication.wait_for_subscription()
                publication.publish(VALUE)
                with pytest.raises(UnknownInterface, match="unknown package `own_msgs` of the type"):
                    await decode_message(here, subscription, await subscription.receive())


RECHARGE = "own_msgs/srv/Recharge"


def with_recharge(types: TypeStore, folder: Path) -> TypeStore:
    """Return the definitions with a service of a package of the robot."""
    (folder / "own_msgs" / "srv").mkdir(parents=True)
    (folder / "own_msgs" / "msg").mkdir()
    (folder / "own_msgs" / "srv" / "Recharge.srv").write_text(
        "own_msgs/Part[] parts\nfloat32 up_to 0.5\n---\nstring summary\n"
    )
    (folder / "own_msgs" / "msg" / "Part.msg").write_text("float64 voltage\n")
    return types.add_folder(folder)


async def recharged(router: str, types: TypeStore, theirs: TypeStore, describer: Describer) -> str:
    """Call a service of a type that only the robot defines; return its response."""

    async def recharge(request: Message) -> Mapping[str, Any]:
        return {"summary": f"{len(request.parts)} parts to {request.up_to}"}

    async with (
        two_nodes(router, types, theirs=theirs) as (there, here),
        there.serving("~/get_type_description", SERVICE, describer.describe),
        there.serving("/recharge", RECHARGE, recharge),
    ):
        with anyio.fail_after(30):
            await here.graph.wait_for(
                lambda seen: seen.servers("/recharge") and seen.servers("/robot/get_type_description")
            )
            node = await node_for_service(here, "/recharge", RECHARGE)
            async with node.calling("/recharge", RECHARGE) as client:
                return str((await client.call({"parts": [{"voltage": 1.5}, {}]}, 20.0)).summary)


async def test_the_definition_of_a_service_of_the_robot_is_requested(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    theirs = with_recharge(types, tmp_path)
    assert await recharged(router, types, theirs, Describer(theirs)) == "2 parts to 0.0"  # without defaults


async def test_a_wrong_definition_of_a_service_is_refused(router: str, types: TypeStore, tmp_path: Path) -> None:
    theirs = with_recharge(types, tmp_path)
    with pytest.raises(UnknownInterface, match="own_msgs"):
        await recharged(router, types, theirs, Liar(theirs))

"""Services, over real sessions and a router."""

import asyncio
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.errors import DefinitionMismatch, NoResponse, NoServiceServer, ServerFailed, WrongType
from seoro.bridges.ros2.interfaces import InvalidValue, Message, TypeStore
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.errors import ActionFailed
from tests.bridges.ros2.systems import ADD, two_nodes

EMPTY = "std_srvs/srv/Empty"


async def add(request: Message) -> Mapping[str, Any]:
    return {"sum": request.a + request.b}


async def test_calls_have_responses(router: str, types: TypeStore) -> None:
    async with (
        two_nodes(router, types) as (there, here),
        there.serving("add", "example_interfaces/AddTwoInts", add),
        here.calling("/add", ADD) as client,
    ):
        await client.wait_for_server(30.0)
        assert (await client.call({"a": 40, "b": 2}, timeout=30)).sum == 42
        assert (await client.call({}, timeout=30)).sum == 0
        with pytest.raises(InvalidValue):
            await client.call({"c": 1}, timeout=30)


async def test_calls_at_the_same_time_have_their_own_responses(router: str, types: TypeStore) -> None:
    async with (
        two_nodes(router, types) as (there, here),
        there.serving("add", ADD, add),
        here.calling("/add", ADD) as client,
    ):
        await client.wait_for_server(30.0)
        calls = [client.call({"a": number, "b": 1}, timeout=30) for number in range(50)]
        assert [response.sum for response in await asyncio.gather(*calls)] == list(range(1, 51))


async def test_a_call_without_a_server_fails_at_once(router: str, types: TypeStore) -> None:
    async with two_nodes(router, types) as (_, here), here.calling("/add", ADD) as client:
        with anyio.fail_after(20.0), pytest.raises(NoServiceServer, match="no server of /add"):
            await client.call({}, timeout=30)
        with pytest.raises(NoServiceServer, match=r"no server of /add within 0.02 s"):
            await client.wait_for_server(0.02)


async def test_a_client_can_wait_for_a_later_server(router: str, types: TypeStore) -> None:
    async with two_nodes(router, types) as (there, here), here.calling("/add", ADD) as client:
        waiting = asyncio.create_task(client.wait_for_server(30.0))
        await asyncio.sleep(0)
        async with there.serving("/add", ADD, add):
            await waiting
            assert (await client.call({"a": 1}, timeout=30)).sum == 1


async def test_a_call_without_a_response_times_out(router: str, types: TypeStore) -> None:
    async def never(_: Message) -> Mapping[str, Any]:
        await anyio.sleep_forever()
        return {}

    async with (
        two_nodes(router, types) as (there, here),
        there.serving("/wait", EMPTY, never),
        here.calling("/wait", EMPTY) as client,
    ):
        await client.wait_for_server(30.0)
        with pytest.raises(NoResponse, match=r"no response from /wait within 0.05 s"):
            await client.call({}, timeout=0.05)


async def test_the_late_response_of_a_cancelled_call_is_dropped(router: str, types: TypeStore) -> None:
    asked, going_on = anyio.Event(), anyio.Event()

    async def slow(request: Message) -> Mapping[str, Any]:
        if request.a == 1:
            asked.set()
            await going_on.wait()
        return {"sum": request.a}

    async with (
        two_nodes(router, types) as (there, here),
        there.serving("/add", ADD, slow),
        here.calling("/add", ADD) as client,
    ):
        await client.wait_for_server(30.0)
        with anyio.fail_after(30.0):
            call = asyncio.create_task(client.call({"a": 1}))
            await asked.wait()
            call.cancel()
            with pytest.raises(asyncio.CancelledError):
                await call
            going_on.set()
            assert (await client.call({"a": 2}, timeout=30)).sum == 2


async def test_a_server_may_respond_with_an_error(router: str, types: TypeStore) -> None:
    async def refuse(_: Message) -> Mapping[str, Any]:
        raise ActionFailed("the gripper is jammed")

    async def wrong(_: Message) -> Mapping[str, Any]:
        return {"som": 1}

    async with (
        two_nodes(router, types) as (there, here),
        there.serving("/refuse", EMPTY, refuse),
        there.serving("/wrong", ADD, wrong),
        here.calling("/refuse", EMPTY) as refused,
        here.calling("/wrong", ADD) as mistaken,
    ):
        for client, reason in ((refused, "the gripper is jammed"), (mistaken, "som")):
            await client.wait_for_server(30.0)
            with pytest.raises(ServerFailed, match=reason):
                await client.call({}, timeout=30)


async def test_a_defect_of_a_server_ends_it(router: str, types: TypeStore) -> None:
    async def defect(_: Message) -> Mapping[str, Any]:
        raise ZeroDivisionError

    async with two_nodes(router, types) as (there, here), here.calling("/wait", EMPTY) as client:
        with pytest.raises(ExceptionGroup) as caught:
            async with there.serving("/wait", EMPTY, defect):
                await client.wait_for_server(30.0)
                with pytest.raises(ServerFailed, match="stopping"):
                    await client.call({}, timeout=30)
                await anyio.sleep_forever()
        assert caught.group_contains(ZeroDivisionError)


async def test_pending_requests_fail_when_the_server_stops(router: str, types: TypeStore) -> None:
    asked = anyio.Event()

    async def never(_: Message) -> Mapping[str, Any]:
        asked.set()
        await anyio.sleep_forever()
        return {}

    async with two_nodes(router, types) as (there, here), here.calling("/wait", EMPTY) as client:
        with anyio.fail_after(30.0):
            async with there.serving("/wait", EMPTY, never):
                await client.wait_for_server()
                call = asyncio.create_task(client.call({}))
                await asked.wait()
            with pytest.raises(ServerFailed, match="stopping"):
                await call


async def test_an_invalid_request_is_refused(router: str, types: TypeStore) -> None:
    dialect = RmwZenoh()
    async with two_nodes(router, types) as (there, here), there.serving("/add", ADD, add):
        await here.graph.wait_for(lambda seen: seen.servers("/add"), 30.0)
        key = dialect.key("/add", ADD, types.type_hash(ADD))
        session = here.system.session
        with pytest.raises(Exception, match="refused") as caught:
            await session.query(key, b"\0\1\0\0x", 5, dialect.attachment(1, 1, bytes(16)))
        assert b"AddTwoInts_Request" in caught.value.payload  # type: ignore[attr-defined]
        response = await session.query(key, b"", 5)  # bridges for DDS may omit empty payloads
        assert types.decode(f"{ADD}_Response", response).sum == 0


async def test_a_server_of_another_definition_or_type_is_not_called(
    router: str, types: TypeStore, tmp_path: Path
) -> None:
    file = tmp_path / "example_interfaces" / "srv" / "AddTwoInts.srv"
    file.parent.mkdir(parents=True)
    file.write_text("int32 a\nint32 b\n---\nint32 sum\n")
    theirs = types.add_folder(tmp_path)
    async with two_nodes(router, types, theirs=theirs) as (there, here), there.serving("/add", ADD, add):
        await here.graph.wait_for(lambda seen: seen.servers("/add"), 30.0)
        async with here.calling("/add", ADD) as client, here.calling("/add", EMPTY) as other:
            with pytest.raises(DefinitionMismatch, match="definitions of example_interfaces/srv/AddTwoInts"):
                await client.call({}, timeout=30)
            with pytest.raises(WrongType, match="/add is of type example_interfaces/srv/AddTwoInts, not std_srvs"):
                await other.call({}, timeout=30)


async def test_clients_are_announced(router: str, types: TypeStore) -> None:
    async with two_nodes(router, types) as (there, here):
        async with here.calling("/add", ADD):
            (client,) = await there.graph.wait_for(lambda seen: seen.clients("/add"), 30.0)
            assert client.type_hash == types.type_hash(ADD)
        await there.graph.wait_for(lambda seen: not seen.clients("/add"), 30.0)

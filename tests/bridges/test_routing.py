"""Routers with keys: forwarding by role, and exclusion of revoked identities."""

from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.asking import ExecutorLost
from seoro.bridges.session import NoServer, Request, Session, open_session
from seoro.bridges.wire import encode
from seoro.bridges.wire.keys import (
    NAMESPACE,
    executor_command,
    executor_token,
    node_command,
    node_stream,
    node_token,
)
from seoro.errors import BackendError, UsageError
from seoro.security.keys.folder import read_keys
from seoro.security.keys.roles import MOVING, Role
from seoro.security.network.endpoint_keys import SERVING_NODES, node_keys, security_of
from tests.executors import HELLO
from tests.labs import NAME, KeyedLab, RunningCommand, command, free_port, keyed_executor, make_lab

DEADLINE = 30.0  # [s]
Naming = Callable[[str, str, str], str]


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    return make_lab(tmp_path_factory.mktemp("lab"))


@pytest.fixture(scope="module")
def router(lab: KeyedLab, tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningCommand]:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    keys = ("--keys", str(lab.keys("hub")))
    with command(tmp_path_factory.mktemp("x") / "log", endpoint, "router", "--listen", endpoint, *keys) as running:
        yield running


def session(router: RunningCommand, lab: KeyedLab, name: str) -> Session:
    return Session(connect=router.endpoint, security=security_of(router.endpoint, read_keys(lab.keys(name))))


def answer(request: Request) -> None:
    request.reply(b"moved")


async def asked(router: RunningCommand, lab: KeyedLab, name: str, key: str) -> bytes:
    security = security_of(router.endpoint, read_keys(lab.keys(name)))
    async with open_session(connect=router.endpoint, security=security) as there:
        return await there.query(key, b"", 5.0)


async def test_commands_reach_nodes_from_roles_that_move_robots_only(
    router: RunningCommand, lab: KeyedLab
) -> None:
    node = session(router, lab, "maze")
    try:
        key = node_command(NAMESPACE, "maze", "step")
        node.answer(node_command(NAMESPACE, "maze", "*"), answer)
        node.declare_token(node_token(NAMESPACE, "maze", "b00t"))
        for name in ("anna", "ada", NAME):
            assert await asked(router, lab, name, key) == b"moved"
        for name in ("vera", "maze", "hub"):
            with pytest.raises(NoServer):
                await asked(router, lab, name, key)
        assert await asked(router, lab, "vera", node_command(NAMESPACE, "maze", "get_lab_state")) == b"moved"
    finally:
        node.close()


@pytest.mark.parametrize("name", ["vera", "anna", "ada", NAME, "hub"])
async def test_other_roles_cannot_act_as_nodes(router: RunningCommand, lab: KeyedLab, name: str) -> None:
    pretender = session(router, lab, name)
    watcher = session(router, lab, "ada")
    try:
        pretender.answer(node_command(NAMESPACE, "forged", "*"), answer)
        pretender.declare_token(node_token(NAMESPACE, "forged", "b00t"))
        with pytest.raises(NoServer):
            await asked(router, lab, "ada", node_command(NAMESPACE, "forged", "step"))
        assert watcher.list_tokens("seoro/1/*/alive/node/forged/*", 1.0) == frozenset()
    finally:
        pretender.close()
        watcher.close()


@pytest.mark.parametrize(
    ("role", "name", "command_of", "token_of"),
    [(Role.EXECUTOR, NAME, executor_command, executor_token), (Role.NODE, "maze", node_command, node_token)],
)
async def test_a_name_is_usable_by_its_owner_only(
    router: RunningCommand,
    lab: KeyedLab,
    tmp_path: Path,
    role: Role,
    name: str,
    command_of: Naming,
    token_of: Naming,
) -> None:
    """Another identity of the role may use unknown names, but not the known names of others."""
    lab.authority.add(f"other-{role.value}", role, tmp_path / "other")
    owner, watcher = session(router, lab, name), session(router, lab, "ada")
    other = Session(connect=router.endpoint, security=security_of(router.endpoint, read_keys(tmp_path / "other")))
    try:
        for pretended in (name, "unheard-of"):
            other.answer(command_of(NAMESPACE, pretended, "*"), lambda request: request.reply(b"forged"))
            other.declare_token(token_of(NAMESPACE, pretended, "0"))
        owner.answer(command_of(NAMESPACE, name, "*"), answer)
        owner.declare_token(token_of(NAMESPACE, name, "1"))
        for pretended, tokens in ((name, {"1"}), ("unheard-of", {"0"})):
            seen = watcher.list_tokens(token_of(NAMESPACE, pretended, "x").replace("/x", "/*"), 1.0)
            assert {token.rpartition("/")[2] for token in seen} == tokens
        for pretended, reply in ((name, b"moved"), ("unheard-of", b"forged")):
            assert await asked(router, lab, "ada", command_of(NAMESPACE, pretended, "challenge")) == reply
    finally:
        for each in (owner, watcher, other):
            each.close()


async def test_streams_of_nodes_are_readable_but_cannot_be_forged(router: RunningCommand, lab: KeyedLab) -> None:
    key, got = node_stream(NAMESPACE, "maze", "camera"), []
    sessions = {name: session(router, lab, name) for name in ("vera", "maze", "anna", "hub")}
    try:
        subscriber = sessions["vera"].handle.declare_subscriber(
            key, lambda sample: got.append(sample.payload.to_bytes())
        )
        mute = sessions["hub"].handle.declare_subscriber(key, lambda sample: got.append(b"seen by a router"))
        with anyio.fail_after(DEADLINE):
            while b"maze" not in got:
                for name in ("maze", "anna"):
                    sessions[name].handle.put(key, name.encode())
                await anyio.sleep(0.02)
        assert set(got) == {b"maze"}
        assert subscriber is not mute  # both are kept until here
    finally:
        for each in sessions.values():
            each.close()


async def test_roles_are_enforced_at_an_executor_behind_a_router(
    router: RunningCommand, lab: KeyedLab, tmp_path: Path
) -> None:
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    with keyed_executor(tmp_path, lab, connect=router.endpoint):
        async with seoro.Client(router.endpoint, lab.keys("anna")) as client:
            assert (await (await client.submit(NAME, file)).result()).passed
        with pytest.raises(NoServer):
            await asked(router, lab, "vera", executor_command(NAMESPACE, NAME, "submit"))
        async with seoro.Client(router.endpoint, lab.keys("vera")) as client:
            [run] = await client.runs()
            assert run.info.by == "anna"


@pytest.mark.more
async def test_roles_are_enforced_behind_a_router_without_access_control(lab: KeyedLab, tmp_path: Path) -> None:
    """A router of another operator, without access control."""
    endpoint = f"tls/127.0.0.1:{free_port()}"
    open_hub = Session(listen=endpoint, security=security_of(endpoint, read_keys(lab.keys("hub"))))
    try:
        with keyed_executor(tmp_path, lab, connect=endpoint):
            security = security_of(endpoint, read_keys(lab.keys("vera")))
            async with open_session(connect=endpoint, security=security) as there:
                key = executor_command(NAMESPACE, NAME, "list_runs")
                with pytest.raises(Exception, match="refused"):
                    await there.query(key, encode(wire.ListRuns()), 5.0)
    finally:
        open_hub.close()


@pytest.mark.more
async def test_revoked_keys_receive_no_reply_through_a_router(lab: KeyedLab, tmp_path: Path) -> None:
    endpoint = f"tls/127.0.0.1:{free_port()}"
    keys = ("--keys", str(lab.keys("hub")))
    lab.authority.add("rob", Role.OPERATOR, lab.keys("rob"))
    with (
        command(tmp_path / "log", endpoint, "router", "--listen", endpoint, *keys),
        keyed_executor(tmp_path, lab, connect=endpoint),
    ):
        async with (
            seoro.Client(endpoint, lab.keys("rob")) as rob,
            seoro.Client(endpoint, lab.keys("anna")) as anna,
        ):
            [reached] = await rob._all()
            reached.patience = 0.2
            assert await rob.runs() == await anna.runs() == []
            lab.revoke("rob", "hub")
            with anyio.fail_after(DEADLINE), pytest.raises(ExecutorLost):
                while True:  # Zenoh may keep the discovery of rob, who receives no reply
                    await reached.ask(wire.LIST_RUNS, wire.ListRuns())
            with anyio.fail_after(DEADLINE):
                while True:
                    with suppress(UsageError):  # the router may connect to the executor anew
                        assert await anna.runs() == []
                        break


def test_routers_and_nodes_need_keys_of_their_roles(lab: KeyedLab, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SEORO_KEYS", str(lab.keys("vera")))
    with pytest.raises(UsageError, match=r"vera \(viewer\); expected role"):
        node_keys("tls/127.0.0.1:1", MOVING)
    assert node_keys("unixsock-stream/hub", SERVING_NODES) is None  # nodes of a run are started with its keys


async def test_connecting_to_a_tls_backend_without_keys_is_refused(lab: KeyedLab, tmp_path: Path) -> None:
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    simulator = seoro.Simulator(endpoint="tls/127.0.0.1:1")
    with pytest.raises((UsageError, BackendError), match="contains no keys"):
        async with seoro.start(seoro.load(file), simulator=simulator):
            pass

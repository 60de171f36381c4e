from __future__ import annotations

import asyncio
import os
import signal
import subprocess
import sys
import weakref
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Generic, cast

import pytest

from seoro.bridges import wire
from seoro.bridges.session import AsyncSession, NoServer, Refused, Request, open_session
from seoro.bridges.wire import (
    Advance,
    Empty,
    LabResult,
    Refusal,
    Result,
    decode,
    encode,
    node_command,
    node_tokens,
    token_node,
)
from seoro.security.network.authorizer import NodeAuthorizer
from sim_nodes.__main__ import ENGINES, INVALID, main
from sim_nodes.node import RequestLoop, keep_pace
from tests.sim_nodes.client import A, Client, Q, pose
from tests.sim_nodes.engines import make_engine

pytestmark = pytest.mark.engine("mujoco")

STARTED_WITHIN = 20.0  # [s]


class Node:
    """A node process and its client."""

    def __init__(self, process: subprocess.Popen[bytes], session: AsyncSession) -> None:
        self.process = process
        self._session = session

    async def ask(self, verb: wire.Verb[Q, A], request: Q) -> A:
        return decode(verb.reply, await self.send(verb.name, encode(request)))

    async def send(self, verb: str, payload: bytes) -> bytes:
        return await self._session.query(node_command("default", "sim", verb), payload, 20.0)


def start(*arguments: str, engine: str = "mujoco") -> subprocess.Popen[bytes]:
    command = [sys.executable, "-m", "sim_nodes", engine, "--node", "sim", *arguments]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE)


@asynccontextmanager
async def running(folder: Path) -> AsyncIterator[Node]:
    """Run a node that exits with its parent, connected to a hub in this process."""
    endpoint = f"unixsock-stream/{folder}/hub"
    async with open_session(listen=endpoint) as session, session.tokens(node_tokens("default")) as tokens:
        process = start("--connect", endpoint, "--world", "empty", "--seed", "3", "--die-with-parent")
        try:
            token, alive = await asyncio.wait_for(anext(tokens), STARTED_WITHIN)
            assert (token_node(token)[0], alive) == ("sim", True)
            yield Node(process, session)
        finally:
            process.kill()
            process.communicate()


async def test_a_node_serves_grants_and_refuses_over_zenoh(tmp_path: Path) -> None:
    async with running(tmp_path) as node:
        features = await node.ask(wire.GET_SIMULATOR_FEATURES, Empty())
        assert (features.engine, features.world) == ("mujoco", "empty")
        assert (await node.ask(wire.ADVANCE, Advance(until=0.5))).time == 0.5
        with pytest.raises(Refused) as refused:
            await node.ask(
                wire.NAVIGATE_THROUGH_POSES,
                wire.NavigateThroughPoses(id="g", robot="turtlebot4", poses=(pose(1.0, 0.0),)),
            )
        refusal = decode(Refusal, refused.value.payload)
        assert refusal.code == Result.INCORRECT_STATE
        assert "initial pose" in refusal.message
        with pytest.raises(Refused) as refused:
            await node.send("advance", b"nonsense")
        assert decode(Refusal, refused.value.payload).code == Result.OPERATION_FAILED
        many = [node.ask(wire.ADVANCE, Advance(until=0.5 + index / 8)) for index in range(1, 11)]
        answers = await asyncio.gather(*many)
        assert [answer.time for answer in answers] == [pytest.approx(0.5 + i / 8, abs=0.005) for i in range(1, 11)]


async def test_a_node_exits_with_its_parent_also_during_a_long_grant(tmp_path: Path) -> None:
    async with running(tmp_path) as node:
        grant = asyncio.create_task(node.ask(wire.ADVANCE, Advance(until=1e6)))
        await asyncio.sleep(0)
        with pytest.raises(TimeoutError):
            await asyncio.wait_for(asyncio.shield(grant), 0.2)
        os.kill(node.process.pid, signal.SIGINT)  # only the parent handles it
        assert node.process.stdin is not None
        node.process.stdin.close()
        node.process.stdin = None
        assert await asyncio.to_thread(node.process.wait, 30.0) == 0
        with pytest.raises(NoServer):
            await grant


@pytest.mark.more
async def test_sigterm_ends_a_node_cleanly(tmp_path: Path) -> None:
    async with running(tmp_path) as node:
        node.process.terminate()
        assert await asyncio.to_thread(node.process.wait, 30.0) == 0


@pytest.mark.parametrize("engine", ENGINES)
def test_a_manually_started_node_prints_its_endpoint_and_exits_on_ctrl_c(tmp_path: Path, engine: str) -> None:
    make_engine(engine)
    endpoint = f"unixsock-stream/{tmp_path}/hub"
    process = start("--listen", endpoint, "--world", "maze", engine=engine)
    try:
        assert process.stdout is not None
        line = process.stdout.readline().decode()
        assert line == f"sim listens on {endpoint} with the world maze; press Ctrl-C to stop\n"
        process.send_signal(signal.SIGINT)
        out, err = process.communicate(timeout=30)
        assert (process.returncode, out, err) == (0, b"", b"")
    finally:
        process.kill()
        process.communicate()


class RecordedRequest(Generic[Q, A]):
    """A request that keeps its answer."""

    attachment = b""
    answer: bytes | None = None
    refusal: Refusal | None = None

    def __init__(self, verb: wire.Verb[Q, A], request: Q) -> None:
        self.key = node_command("default", "sim", verb.name)
        self.payload = encode(request)

    def reply(self, payload: bytes) -> None:
        self.answer = payload

    def refuse(self, payload: bytes) -> None:
        self.refusal = decode(Refusal, payload)


def test_a_fault_in_a_handler_is_refused_and_logged(
    maze: Client, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    def fault() -> None:
        raise ZeroDivisionError("a wheel came off")

    monkeypatch.setattr(maze.simulator, "features", fault)
    request = RecordedRequest(wire.GET_SIMULATOR_FEATURES, Empty())
    RequestLoop(maze.simulator, NodeAuthorizer()).answer(cast("Request", request))
    assert request.answer is None
    assert request.refusal is not None
    assert request.refusal.code == LabResult.FAULT
    assert request.refusal.message == "fault in the simulator node: ZeroDivisionError: a wheel came off"
    assert "fault in get_simulator_features" in caplog.text


def test_a_replaced_simulation_leaves_no_garbage(maze: Client) -> None:
    request = RecordedRequest(wire.LOAD_WORLD, wire.LoadWorld(world="empty"))
    before = weakref.ref(maze.simulator.simulation)
    RequestLoop(maze.simulator, NodeAuthorizer()).answer(cast("Request", request))
    assert maze.simulator.simulation.world.name == "empty"
    assert before() is None


def test_a_fault_while_playing_pauses_the_simulation(empty: Client, monkeypatch: pytest.MonkeyPatch) -> None:
    def fault(count: int) -> int:
        raise ZeroDivisionError("a wheel came off")

    empty.ask(wire.SET_SIMULATION_STATE, wire.SetSimulationState(state=wire.SimulationState.PLAYING))
    monkeypatch.setattr(empty.simulator.simulation.engine, "step", fault)
    keep_pace(empty.simulator, 0.0)
    assert keep_pace(empty.simulator, 0.1) is None
    assert empty.simulator.state is wire.SimulationState.PAUSED


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("--world", "moon", "--listen"), "unknown world 'moon'"),
        (("--node", "Sim 1", "--listen"), "invalid name 'Sim 1' of a node"),
        (("--connect",), "cannot connect to"),
    ],
)
def test_start_errors_are_one_sentence(
    arguments: tuple[str, ...], words: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    handler = signal.getsignal(signal.SIGTERM)
    try:
        assert main(["mujoco", *arguments, f"unixsock-stream/{tmp_path}/nowhere"]) == INVALID
    finally:
        signal.signal(signal.SIGTERM, handler)
    assert words in capsys.readouterr().err

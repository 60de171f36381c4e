"""Requests in the name of a client that holds robots, by others who change or repeat them, or know the name."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

import msgpack
import pytest

from seoro.background import background
from seoro.bridges import wire
from seoro.bridges.leasing.latch import Latch
from seoro.bridges.ledger import Ledger
from seoro.bridges.lock import Lock
from seoro.bridges.revoked import Revoked
from seoro.bridges.robot.connecting import held
from seoro.bridges.seals import node_seals
from seoro.bridges.serving.gate import NodeGate
from seoro.bridges.serving.happenings import HappeningLog
from seoro.bridges.serving.node import RobotServer
from seoro.bridges.serving.work import Work
from seoro.bridges.session import Answer, AsyncSession, Check, Request, form_of
from seoro.bridges.session.asynchronous import Reply
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.bridges.wire.proving import DENIED
from seoro.bridges.wire.refusal import said_in
from seoro.errors import BackendLost, BackendRefused
from seoro.keys.audit import Audit
from seoro.keys.folder import Keys, read_keys
from sim_nodes.node import Serving
from tests.bridges.serving.test_stopping import SlowRobot, forward
from tests.labs import KeyedLab, make_lab
from tests.sim_nodes.client import Client

pytestmark = pytest.mark.anyio

NODE = "maze"
RUN = "run-7"
CODE = "its code is wrong or missing"
REPEATED = "it was sent before, or too late"
NOT_SENT = "which has not sent it"


@dataclass(frozen=True)
class Sent:
    """A request on its way."""

    verb: str
    payload: bytes
    beside: bytes


@dataclass
class Query:
    """A query of Zenoh's that is answered here."""

    sent: Sent
    answers: list[Answer] = field(default_factory=list)

    def __enter__(self) -> None: ...

    def __exit__(self, *_error: object) -> None: ...

    @property
    def payload(self) -> Query:
        return self

    def to_bytes(self) -> bytes:
        return self.sent.payload

    def reply(self, _key: str, payload: bytes, attachment: bytes | None = None) -> None:
        self.answers.append(Answer(True, payload, attachment or b""))

    def reply_err(self, payload: bytes) -> None:
        self.answers.append(Answer(False, payload))


@dataclass
class Router:
    """Connects a client and a node of the same process; a test changes what passes."""

    gate: NodeGate
    receive: Callable[[Request], Awaitable[None]]
    change: Callable[[Sent], Sent] = lambda sent: sent
    seen: list[Sent] = field(default_factory=list)

    @asynccontextmanager
    async def token(self, _key: str) -> AsyncIterator[None]:
        yield

    async def query(
        self,
        key: str,
        payload: bytes,
        _timeout: float,
        attachment: bytes | None = None,
        *,
        check: Check = form_of,
        is_urgent: bool = False,
    ) -> bytes:
        del is_urgent
        sent = Sent(key.rpartition("/")[2], payload, attachment or b"")
        self.seen.append(sent)
        return Reply(tuple(await self.deliver(self.change(sent)))).value(key, check)

    async def deliver(self, sent: Sent) -> list[Answer]:
        key, query = wire.node_command(wire.NAMESPACE, NODE, sent.verb), Query(sent)
        assert self.gate.attestor is not None
        inner, envelope = self.gate.attestor.open(key, sent.beside)
        await self.receive(Request(key, len(sent.payload), inner, query, lambda *_: None, envelope))
        return query.answers

    async def refused(self, sent: Sent, why: str) -> None:
        """Deliver a request that the node refuses."""
        (answer,) = await self.deliver(sent)
        refusal = said_in(answer.payload)
        assert refusal.code == DENIED
        assert why in refusal.message

    def last(self, verb: wire.Verb[Any, Any]) -> Sent:
        return next(sent for sent in reversed(self.seen) if sent.verb == verb.name)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    return make_lab(tmp_path_factory.mktemp("lab"))


@pytest.fixture(scope="module")
def anna(lab: KeyedLab) -> Keys:
    return read_keys(lab.keys("anna"))


@pytest.fixture
def log(tmp_path: Path) -> Path:
    return tmp_path / "log.jsonl"


@pytest.fixture
def gate(lab: KeyedLab, log: Path) -> Iterator[NodeGate]:
    keys = read_keys(lab.keys(NODE))
    with closing(Audit(log, keys)) as audit:
        yield NodeGate(Lock(keys, Revoked(keys), Ledger(audit)))


def address_of(router: Router, anna: Keys) -> NodeAddress:
    session = cast(AsyncSession, router)
    return NodeAddress(session, wire.NAMESPACE, NODE, sender=RUN, seals=node_seals(session, NODE, anna))


@dataclass(frozen=True)
class Held:
    """A simulator that a run holds."""

    simulator: Client
    router: Router
    address: NodeAddress
    serving: Serving

    async def advance(self, until: float) -> None:
        await ask(self.address, wire.ADVANCE, wire.Advance(until=until))

    @property
    def time(self) -> float:
        return self.simulator.simulator.time


@pytest.fixture
async def sim(gate: NodeGate, anna: Keys) -> AsyncIterator[Held]:
    simulator = Client("empty")
    serving = Serving(simulator.simulator, gate)

    async def receive(request: Request) -> None:
        serving._receive(request)

    router = Router(gate, receive)
    address = address_of(router, anna)
    async with held(address, wire.Holder(holder=RUN, gives_signs=False)):
        yield Held(simulator, router, address, serving)
        router.change = lambda sent: sent


async def test_the_holder_is_obeyed_and_each_request_once(sim: Held, log: Path) -> None:
    await sim.advance(0.1)
    await sim.advance(0.2)
    for sent in sim.router.seen:
        if sent.verb == wire.ADVANCE.name:
            await sim.router.refused(sent, REPEATED)
    await ask(sim.address, wire.GET_SIMULATION_STATE, wire.Empty())
    assert sim.time == pytest.approx(0.2)
    lines = [json.loads(line) for line in log.read_bytes().splitlines()]
    assert [line["outcome"] for line in lines if line["what"] == wire.ADVANCE.name] == ["refused"] * 2


async def test_whoever_knows_the_name_moves_nothing(sim: Held, anna: Keys) -> None:
    """Also an operator, and with a key pair of their own."""
    await sim.advance(0.1)
    payload = wire.encode(wire.Advance(until=5.0))
    seals = node_seals(cast(AsyncSession, sim.router), NODE, anna)
    assert seals is not None
    await seals.prove()
    checker = seals._checker
    checker._pair = type(checker._pair)()
    assert seals.identify(wire.Holder(holder=RUN)).exchange == checker._pair.public
    lock = sim.router.gate.lock
    assert lock is not None
    checker.share(lock.answers._keys.identity, lock.boot, lock.answers.exchange)
    for verb in (wire.ADVANCE, wire.SET_ENTITY_STATE, wire.STEP_SIMULATION, wire.CMD_VEL, wire.RELEASE_ROBOTS):
        key = wire.node_command(wire.NAMESPACE, NODE, verb.name)
        own, _ = checker.prepare(key, payload, wire.sender(RUN), has_code=True)
        for beside in (wire.sender(RUN), own):
            await sim.router.refused(Sent(verb.name, payload, beside), CODE)
    await sim.advance(0.2)
    assert sim.time == pytest.approx(0.2)


async def test_a_router_changes_nothing(sim: Held) -> None:
    """The content, the verb, the name, the number, and the code."""
    await sim.advance(0.1)
    before = sim.router.last(wire.ADVANCE)
    public, boot, numbered, inner = msgpack.unpackb(before.beside)
    later = replace(before, beside=msgpack.packb([public, boot, [numbered[0] + 1000, numbered[1]], inner]))
    without = replace(before, beside=msgpack.packb([public, boot, [numbered[0] + 1000, b""], inner]))
    for sent in (later, without, replace(before, verb=wire.STEP_SIMULATION.name)):
        await sim.router.refused(sent, CODE)
    sim.router.change = lambda sent: replace(sent, payload=wire.encode(wire.Advance(until=9.0)))
    with pytest.raises(BackendLost, match="is not authentic"):
        await sim.advance(0.2)
    sim.router.change = lambda sent: sent
    await sim.advance(0.3)
    assert sim.time == pytest.approx(0.3)


async def test_requests_may_overtake_each_other(sim: Held) -> None:
    kept: list[Sent] = []

    def keep(sent: Sent) -> Sent:
        kept.append(sent)
        return replace(sent, payload=b"")

    sim.router.change = keep
    for until in (0.1, 0.2):
        with pytest.raises(BackendLost):
            await sim.advance(until)
    sim.router.change = lambda sent: sent
    for sent in (kept[1], kept[0]):
        (answer,) = await sim.router.deliver(sent)
        assert answer.is_ok
    assert sim.time == pytest.approx(0.2)


async def test_others_do_not_hold_or_release_for_the_holder(sim: Held) -> None:
    """With no name beside the request, or another one."""
    hold = sim.serving.leasing._leases.hold_of(RUN)
    assert hold is not None
    last = hold.last
    holding = Sent(wire.HOLD_ROBOTS.name, wire.encode(wire.HoldRobots(holder=RUN, since=0, wait=0.05)), b"")
    releasing = Sent(wire.RELEASE_ROBOTS.name, wire.encode(wire.Holder(holder=RUN)), b"")
    for sent in (holding, releasing):
        for beside in (b"", wire.sender("run-8")):
            await sim.router.refused(replace(sent, beside=beside), NOT_SENT)
        await sim.router.refused(replace(sent, beside=wire.sender(RUN)), CODE)
    assert sim.serving.leasing._leases.hold_of(RUN) is hold
    assert hold.last == last


async def test_robots_are_taken_with_the_key_of_the_name(sim: Held, anna: Keys) -> None:
    with pytest.raises(BackendRefused, match="has no public key: update the seoro of the client"):
        await ask(sim.address, wire.TAKE_ROBOTS, wire.Holder(holder="run-8"))
    other = wire.Holder(holder=RUN, exchange=bytes(range(32)), gives_signs=False)
    with pytest.raises(BackendRefused, match="another client holds robots as"):
        await ask(sim.address, wire.TAKE_ROBOTS, other)
    await sim.advance(0.1)


async def test_a_new_connection_of_the_run_goes_on(sim: Held, anna: Keys) -> None:
    """And nothing that was recorded before it took its robots again is accepted after."""
    await sim.advance(0.1)
    before = sim.router.last(wire.ADVANCE)
    again = replace(sim, address=address_of(sim.router, anna))
    await again.advance(0.2)  # with the hold that it has
    async with held(again.address, wire.Holder(holder=RUN, gives_signs=False)):
        await sim.router.refused(before, REPEATED)
        await again.advance(0.3)
        await sim.advance(0.4)
        releasing = sim.router.seen
    async with held(again.address, wire.Holder(holder=RUN, gives_signs=False)):
        await sim.router.refused(next(each for each in releasing if each.verb == "release_robots"), REPEATED)
        await again.advance(0.5)
    assert sim.time == pytest.approx(0.5)


async def test_a_bridge_obeys_the_holder_only(gate: NodeGate, anna: Keys) -> None:
    async with background() as tasks:
        happenings = HappeningLog()
        robot = SlowRobot(work := Work(tasks, happenings))
        robot.ready.set()
        server = RobotServer([robot], work, happenings, tasks, Latch(), gate)
        router = Router(gate, server.answer)
        address = address_of(router, anna)
        async with held(address, wire.Holder(holder=RUN)):
            await ask(address, wire.CMD_VEL, forward("slow"))
            await ask(address, wire.HOLD_ROBOTS, wire.HoldRobots(holder=RUN, since=0))
            assert robot.velocity == 1.0
            robot.velocity = 0.0
            for verb in (wire.CMD_VEL, wire.HOLD_ROBOTS):
                await router.refused(router.last(verb), REPEATED)
                await router.refused(replace(router.last(verb), beside=wire.sender(RUN)), CODE)
            releasing = Sent(wire.RELEASE_ROBOTS.name, wire.encode(wire.Holder(holder=RUN)), b"")
            await router.refused(releasing, NOT_SENT)
            await router.refused(replace(releasing, beside=wire.sender(RUN)), CODE)
            assert robot.velocity == 0.0
            await ask(address, wire.CMD_VEL, forward("slow"))
            assert robot.velocity == 1.0
        assert robot.velocity == 0.0

"""Forged, changed and repeated requests in the name of a client that holds robots."""

from __future__ import annotations

import json
from collections.abc import AsyncIterator, Awaitable, Callable, Iterator
from contextlib import asynccontextmanager, closing
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, cast

import msgpack
import pytest

from seoro.bridges import wire
from seoro.bridges.leasing.emergency_stop import EmergencyStopState
from seoro.bridges.robot.connecting import held
from seoro.bridges.serving.event_log import EventLog
from seoro.bridges.serving.node import RobotServer
from seoro.bridges.serving.work import Work
from seoro.bridges.session import Answer, AsyncSession, Check, Request, form_of
from seoro.bridges.session.asynchronous import select_answer
from seoro.bridges.sim.requests import NodeAddress, ask
from seoro.bridges.wire.authentication import DENIED
from seoro.bridges.wire.refusal import read_refusal
from seoro.concurrency.background import background
from seoro.errors import BackendLost, BackendRefused
from seoro.security.keys.folder import Keys, read_keys
from seoro.security.network.audit_trail import AuditTrail
from seoro.security.network.authorizer import NodeAuthorizer
from seoro.security.network.node_identity import NodeIdentity
from seoro.security.network.peers import node_signer
from seoro.security.network.revocation_monitor import RevocationMonitor
from seoro.security.signing.audit_log import AuditLog
from sim_nodes.node import RequestLoop
from tests.bridges.serving.test_stopping import SlowRobot, forward
from tests.labs import KeyedLab, make_lab
from tests.sim_nodes.client import Client

pytestmark = pytest.mark.anyio

NODE = "maze"
RUN = "run-7"
CODE = "its code is invalid or missing"
REPEATED = "it was received before, or too late"
NOT_SENT = "but another client sent it"


@dataclass(frozen=True)
class Sent:
    """A request in transit."""

    verb: str
    payload: bytes
    attachment: bytes


@dataclass
class Query:
    """A Zenoh query that the test answers."""

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
    """A connection between a client and a node of one process; a test changes its messages."""

    authorizer: NodeAuthorizer
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
        return select_answer(await self.deliver(self.change(sent)), key, check)[1]

    async def deliver(self, sent: Sent) -> list[Answer]:
        key, query = wire.node_command(wire.NAMESPACE, NODE, sent.verb), Query(sent)
        assert self.authorizer.attestor is not None
        inner, envelope = self.authorizer.attestor.open(key, sent.attachment)
        await self.receive(Request(key, len(sent.payload), inner, query, lambda *_: None, envelope))
        return query.answers

    async def refused(self, sent: Sent, why: str) -> None:
        """Deliver a request that the node refuses."""
        (answer,) = await self.deliver(sent)
        refusal = read_refusal(answer.payload)
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
def authorizer(lab: KeyedLab, log: Path) -> Iterator[NodeAuthorizer]:
    keys = read_keys(lab.keys(NODE))
    with closing(AuditLog(log, keys)) as audit:
        yield NodeAuthorizer(NodeIdentity(keys, RevocationMonitor(keys), AuditTrail(audit)))


def address_of(router: Router, anna: Keys) -> NodeAddress:
    session = cast(AsyncSession, router)
    return NodeAddress(session, wire.NAMESPACE, NODE, sender=RUN, signer=node_signer(session, NODE, anna))


@dataclass(frozen=True)
class Held:
    """A simulator that a run holds."""

    simulator: Client
    router: Router
    address: NodeAddress
    serving: RequestLoop

    async def advance(self, until: float) -> None:
        await ask(self.address, wire.ADVANCE, wire.Advance(until=until))

    @property
    def time(self) -> float:
        return self.simulator.simulator.time


@pytest.fixture
async def sim(authorizer: NodeAuthorizer, anna: Keys) -> AsyncIterator[Held]:
    simulator = Client("empty")
    serving = RequestLoop(simulator.simulator, authorizer)

    async def receive(request: Request) -> None:
        serving._receive(request)

    router = Router(authorizer, receive)
    address = address_of(router, anna)
    async with held(address, wire.Holder(holder=RUN, gives_signs=False)):
        yield Held(simulator, router, address, serving)
        router.change = lambda sent: sent


async def test_requests_of_the_holder_are_accepted_once(sim: Held, log: Path) -> None:
    await sim.advance(0.1)
    await sim.advance(0.2)
    for sent in sim.router.seen:
        if sent.verb == wire.ADVANCE.name:
            await sim.router.refused(sent, REPEATED)
    await ask(sim.address, wire.GET_SIMULATION_STATE, wire.Empty())
    assert sim.time == pytest.approx(0.2)
    lines = [json.loads(line) for line in log.read_bytes().splitlines()]
    assert [line["outcome"] for line in lines if line["what"] == wire.ADVANCE.name] == ["refused"] * 2


async def test_the_name_of_a_holder_alone_moves_no_robot(sim: Held, anna: Keys) -> None:
    """An operator with another key pair is refused, too."""
    await sim.advance(0.1)
    payload = wire.encode(wire.Advance(until=5.0))
    signer = node_signer(cast(AsyncSession, sim.router), NODE, anna)
    assert signer is not None
    await signer.verify_peer()
    checker = signer._checker
    checker._pair = type(checker._pair)()
    assert signer.add_holder_key(wire.Holder(holder=RUN)).exchange == checker._pair.public
    identity = sim.router.authorizer.identity
    assert identity is not None
    checker.share(identity.answers._keys.identity, identity.boot, identity.answers.exchange)
    for verb in (wire.ADVANCE, wire.SET_ENTITY_STATE, wire.STEP_SIMULATION, wire.CMD_VEL, wire.RELEASE_ROBOTS):
        key = wire.node_command(wire.NAMESPACE, NODE, verb.name)
        own, _ = checker.prepare(key, payload, wire.encode_sender(RUN), has_code=True)
        for attachment in (wire.encode_sender(RUN), own):
            await sim.router.refused(Sent(verb.name, payload, attachment), CODE)
    await sim.advance(0.2)
    assert sim.time == pytest.approx(0.2)


async def test_requests_changed_by_a_router_are_refused(sim: Held) -> None:
    """Changes of content, verb, name, number and code are refused."""
    await sim.advance(0.1)
    before = sim.router.last(wire.ADVANCE)
    public, boot, numbered, inner = msgpack.unpackb(before.attachment)
    later = replace(before, attachment=msgpack.packb([public, boot, [numbered[0] + 1000, numbered[1]], inner]))
    without = replace(before, attachment=msgpack.packb([public, boot, [numbered[0] + 1000, b""], inner]))
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


async def test_holding_and_releasing_for_another_holder_is_refused(sim: Held) -> None:
    """The name of the request is missing or differs."""
    hold = sim.serving.leasing.leases.hold_of(RUN)
    assert hold is not None
    last = hold.last
    holding = Sent(wire.HOLD_ROBOTS.name, wire.encode(wire.HoldRobots(holder=RUN, since=0, wait=0.05)), b"")
    releasing = Sent(wire.RELEASE_ROBOTS.name, wire.encode(wire.Holder(holder=RUN)), b"")
    for sent in (holding, releasing):
        for attachment in (b"", wire.encode_sender("run-8")):
            await sim.router.refused(replace(sent, attachment=attachment), NOT_SENT)
        await sim.router.refused(replace(sent, attachment=wire.encode_sender(RUN)), CODE)
    assert sim.serving.leasing.leases.hold_of(RUN) is hold
    assert hold.last == last


async def test_taking_robots_requires_the_key_of_the_holder(sim: Held, anna: Keys) -> None:
    with pytest.raises(BackendRefused, match="missing public key in the request"):
        await ask(sim.address, wire.TAKE_ROBOTS, wire.Holder(holder="run-8"))
    other = wire.Holder(holder=RUN, exchange=bytes(range(32)), gives_signs=False)
    with pytest.raises(BackendRefused, match="another client holds robots as"):
        await ask(sim.address, wire.TAKE_ROBOTS, other)
    await sim.advance(0.1)


async def test_a_run_continues_over_a_new_connection(sim: Held, anna: Keys) -> None:
    """Requests recorded before the new connection are refused."""
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


async def test_a_bridge_accepts_commands_of_the_holder_only(authorizer: NodeAuthorizer, anna: Keys) -> None:
    async with background() as tasks:
        events = EventLog()
        robot = SlowRobot(work := Work(tasks, events))
        robot.ready.set()
        server = RobotServer([robot], work, events, tasks, EmergencyStopState(), authorizer)
        router = Router(authorizer, server.answer)
        address = address_of(router, anna)
        async with held(address, wire.Holder(holder=RUN)):
            await ask(address, wire.CMD_VEL, forward("slow"))
            await ask(address, wire.HOLD_ROBOTS, wire.HoldRobots(holder=RUN, since=0))
            assert robot.velocity == 1.0
            robot.velocity = 0.0
            for verb in (wire.CMD_VEL, wire.HOLD_ROBOTS):
                await router.refused(router.last(verb), REPEATED)
                await router.refused(replace(router.last(verb), attachment=wire.encode_sender(RUN)), CODE)
            releasing = Sent(wire.RELEASE_ROBOTS.name, wire.encode(wire.Holder(holder=RUN)), b"")
            await router.refused(releasing, NOT_SENT)
            await router.refused(replace(releasing, attachment=wire.encode_sender(RUN)), CODE)
            assert robot.velocity == 0.0
            await ask(address, wire.CMD_VEL, forward("slow"))
            assert robot.velocity == 1.0
        assert robot.velocity == 0.0

"""Claim of an executor name: tokens, recorded answers and clocks do not take it from its owner."""

from __future__ import annotations

import secrets
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import ExitStack, asynccontextmanager, closing
from pathlib import Path

import anyio
import pytest

from seoro.bridges.session import AsyncSession, Bound, open_session
from seoro.bridges.wire.authentication import CLAIM, Challenge, Claim
from seoro.bridges.wire.keys import NAMESPACE, executor_command, executor_token
from seoro.bridges.wire.message import decode, encode
from seoro.concurrency.background import background
from seoro.errors import UsageError
from seoro.executor.name_claim import NameClaim
from seoro.security.keys.folder import read_keys
from seoro.security.keys.roles import Role
from seoro.security.network.audit_trail import AuditTrail
from seoro.security.network.node_identity import NodeIdentity
from seoro.security.network.revocation_monitor import RevocationMonitor
from seoro.security.signing.audit_log import AuditLog
from tests.labs import NAME, KeyedLab, make_lab
from tests.routers import routing

pytestmark = pytest.mark.anyio

HOUR = 3600 * 10**9
FORGED = executor_token(NAMESPACE, NAME, "3-000000000000deadbeef")
KEY = executor_command(NAMESPACE, NAME, CLAIM.name)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    made = make_lab(tmp_path_factory.mktemp("lab"))
    made.authority.add("lab-b", Role.EXECUTOR, made.path / "lab-b")
    return made


@pytest.fixture
def identities(lab: KeyedLab, tmp_path: Path) -> Iterator[Callable[[str], NodeIdentity]]:
    """Return a function that creates the identity of an executor."""
    with ExitStack() as stack:

        def make(name: str) -> NodeIdentity:
            keys = read_keys(lab.keys(name))
            audit = stack.enter_context(closing(AuditLog(tmp_path / f"{secrets.token_hex(4)}.jsonl", keys)))
            return NodeIdentity(keys, RevocationMonitor(keys), AuditTrail(audit))

        yield make


@pytest.fixture
def identity(identities: Callable[[str], NodeIdentity]) -> NodeIdentity:
    return identities(NAME)


@pytest.fixture(autouse=True)
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.bridges.naming.PATIENCE", 0.05)
    monkeypatch.setattr("seoro.executor.name_claim.RETRY_PERIOD", 0.05)


class Clock:
    """Clock that a test sets [ns]."""

    def __init__(self) -> None:
        self.now = 0

    def __call__(self) -> int:
        return self.now


def aged(age: int, identity: NodeIdentity | None = None) -> NameClaim:
    """Return the name claim of an executor that has run for some time [ns]."""
    clock = Clock()
    name = NameClaim(NAME, identity, clock)
    clock.now = age
    return name


@asynccontextmanager
async def answering(session: AsyncSession, answer: Callable[[Challenge], Claim]) -> AsyncIterator[list[Challenge]]:
    """Answer requests for claims; yield the requests."""
    asked: list[Challenge] = []

    async def answer_all() -> None:
        async for request in requests:
            asked.append(decode(Challenge, request.payload))
            request.reply(encode(answer(asked[-1])))

    async with session.answering(KEY, Bound(10, drop="newest"), b"") as requests, background() as tasks:
        tasks.start_soon(answer_all)
        yield asked


@asynccontextmanager
async def sessions() -> AsyncIterator[tuple[AsyncSession, AsyncSession]]:
    with routing() as endpoint:
        async with open_session(connect=endpoint) as here, open_session(connect=endpoint) as there:
            yield here, there


async def keeps_its_name(name: NameClaim, session: AsyncSession, asked: list[Challenge] | None = None) -> bool:
    """Return whether an executor keeps its name for a while, with two requests if another one answers."""
    kept = True

    async def wait(scope: anyio.CancelScope) -> None:
        nonlocal kept
        await name.wait_for_elder(session)
        kept = False
        scope.cancel()

    with anyio.move_on_after(0.5 if asked is None else 20.0):
        async with anyio.create_task_group() as tasks:
            tasks.start_soon(wait, tasks.cancel_scope)
            while asked is None or len(asked) < 2:
                await anyio.sleep(0.01)
            tasks.cancel_scope.cancel()
    return kept


@pytest.mark.parametrize("has_keys", [False, True])
async def test_a_token_without_a_claim_takes_no_name(identity: NodeIdentity, has_keys: bool) -> None:
    name = aged(0, identity if has_keys else None)
    async with sessions() as (here, there), there.token(FORGED), here.token(name.token):
        await name.wait_until_free(here)
        await name.check_first(here)
        assert await keeps_its_name(name, here)


@pytest.mark.parametrize(("age", "keeps"), [(2 * HOUR, False), (HOUR // 2, True)])
async def test_the_older_executor_keeps_the_name(
    identity: NodeIdentity, identities: Callable[[str], NodeIdentity], age: int, keeps: bool
) -> None:
    for one, two in ((None, None), (identity, identities(NAME))):
        ours, theirs = aged(HOUR, one), aged(age, two)
        async with sessions() as (here, there), answering(there, theirs.claim), there.token(theirs.token):
            with anyio.move_on_after(0.5 if keeps else 20.0) as waited:
                await ours.wait_for_elder(here)
            assert waited.cancelled_caught is keeps
            with pytest.raises(UsageError, match="duplicate executor 'lab-a'"):
                await ours.wait_until_free(here)


async def test_one_of_two_simultaneously_started_executors_has_the_name() -> None:
    one, two = aged(0), aged(0)
    refused = 0
    async with (
        sessions() as (here, there),
        answering(here, one.claim),
        here.token(one.token),
        answering(there, two.claim),
        there.token(two.token),
    ):
        for name, session in ((one, here), (two, there)):
            try:
                await name.check_first(session)
            except UsageError:
                refused += 1
    assert refused == 1


async def test_a_claim_by_another_executor_takes_no_name(
    identity: NodeIdentity, identities: Callable[[str], NodeIdentity]
) -> None:
    name = aged(HOUR, identity)
    for forging in (identities("lab-b"), None):
        async with (
            sessions() as (here, there),
            answering(there, aged(2 * HOUR, forging).claim) as asked,
            there.token(FORGED),
        ):
            assert await keeps_its_name(name, here, asked)


async def test_a_replayed_claim_takes_no_name(identity: NodeIdentity) -> None:
    name = aged(HOUR, identity)
    recorded = aged(2 * HOUR, identity).claim(Challenge(nonce=secrets.token_bytes(16)))
    recorded = recorded.model_copy(update={"boot": "0"})
    async with (
        sessions() as (here, there),
        answering(there, lambda _: recorded) as asked,
        there.token(FORGED),
    ):
        assert await keeps_its_name(name, here, asked)

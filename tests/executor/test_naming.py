"""The name of an executor: no token, no recorded answer and no clock takes it from one that has it."""

from __future__ import annotations

import secrets
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import ExitStack, asynccontextmanager, closing
from pathlib import Path

import anyio
import pytest

from seoro.background import background
from seoro.bridges.ledger import Ledger
from seoro.bridges.lock import Lock
from seoro.bridges.revoked import Revoked
from seoro.bridges.session import AsyncSession, Bound, open_session
from seoro.bridges.wire.keys import NAMESPACE, executor_command, executor_token
from seoro.bridges.wire.message import decode, encode
from seoro.bridges.wire.proving import CLAIM, Challenge, Claim
from seoro.errors import InvalidUse
from seoro.executor.naming import Name
from seoro.keys.audit import Audit
from seoro.keys.folder import read_keys
from seoro.keys.roles import Role
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
def locks(lab: KeyedLab, tmp_path: Path) -> Iterator[Callable[[str], Lock]]:
    """Makes the lock of an executor of a name."""
    with ExitStack() as stack:

        def make(name: str) -> Lock:
            keys = read_keys(lab.keys(name))
            audit = stack.enter_context(closing(Audit(tmp_path / f"{secrets.token_hex(4)}.jsonl", keys)))
            return Lock(keys, Revoked(keys), Ledger(audit))

        yield make


@pytest.fixture
def lock(locks: Callable[[str], Lock]) -> Lock:
    return locks(NAME)


@pytest.fixture(autouse=True)
def short(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("seoro.bridges.naming.PATIENCE", 0.05)
    monkeypatch.setattr("seoro.executor.naming.AGAIN", 0.05)


class Clock:
    """A clock that only goes on when it is told to [ns]."""

    def __init__(self) -> None:
        self.now = 0

    def __call__(self) -> int:
        return self.now


def aged(age: int, lock: Lock | None = None) -> Name:
    """The name of an executor that has run for some time [ns]."""
    clock = Clock()
    name = Name(NAME, lock, clock)
    clock.now = age
    return name


@asynccontextmanager
async def answering(session: AsyncSession, answer: Callable[[Challenge], Claim]) -> AsyncIterator[list[Challenge]]:
    """Answer those who ask for claims; gives what they have asked."""
    asked: list[Challenge] = []

    async def answer_all() -> None:
        async for request in requests:
            asked.append(decode(Challenge, request.payload))
            request.reply(encode(answer(asked[-1])))

    async with session.answering(KEY, Bound(10, lose="newest"), b"") as requests, background() as tasks:
        tasks.start_soon(answer_all)
        yield asked


@asynccontextmanager
async def sessions() -> AsyncIterator[tuple[AsyncSession, AsyncSession]]:
    with routing() as endpoint:
        async with open_session(connect=endpoint) as here, open_session(connect=endpoint) as there:
            yield here, there


async def keeps_its_name(name: Name, session: AsyncSession, asked: list[Challenge] | None = None) -> bool:
    """Whether an executor keeps its name for a while, in which it was asked twice if somebody answers."""
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
async def test_a_token_alone_takes_no_name(lock: Lock, has_keys: bool) -> None:
    name = aged(0, lock if has_keys else None)
    async with sessions() as (here, there), there.token(FORGED), here.token(name.token):
        await name.wait_until_free(here)
        await name.check_first(here)
        assert await keeps_its_name(name, here)


@pytest.mark.parametrize(("age", "keeps"), [(2 * HOUR, False), (HOUR // 2, True)])
async def test_who_has_run_longer_keeps_the_name(
    lock: Lock, locks: Callable[[str], Lock], age: int, keeps: bool
) -> None:
    for one, two in ((None, None), (lock, locks(NAME))):
        ours, theirs = aged(HOUR, one), aged(age, two)
        async with sessions() as (here, there), answering(there, theirs.claim), there.token(theirs.token):
            with anyio.move_on_after(0.5 if keeps else 20.0) as waited:
                await ours.wait_for_elder(here)
            assert waited.cancelled_caught is keeps
            with pytest.raises(InvalidUse, match="there is an executor 'lab-a' already"):
                await ours.wait_until_free(here)


async def test_of_two_that_start_at_once_one_has_the_name() -> None:
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
            except InvalidUse:
                refused += 1
    assert refused == 1


async def test_another_executor_of_the_lab_takes_no_name(lock: Lock, locks: Callable[[str], Lock]) -> None:
    name = aged(HOUR, lock)
    for forging in (locks("lab-b"), None):
        async with (
            sessions() as (here, there),
            answering(there, aged(2 * HOUR, forging).claim) as asked,
            there.token(FORGED),
        ):
            assert await keeps_its_name(name, here, asked)


async def test_a_recorded_claim_takes_no_name(lock: Lock) -> None:
    name = aged(HOUR, lock)
    recorded = aged(2 * HOUR, lock).claim(Challenge(nonce=secrets.token_bytes(16)))
    recorded = recorded.model_copy(update={"boot": "0"})
    async with (
        sessions() as (here, there),
        answering(there, lambda _: recorded) as asked,
        there.token(FORGED),
    ):
        assert await keeps_its_name(name, here, asked)

"""Replies in parts that an attacker changes: real keys and real sessions."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from seoro.bridges.executor import messages
from seoro.bridges.executor.asking import Executor, ExecutorLost, Unavailable
from seoro.bridges.executor.messages import RECORDS, AskRecords, NewRecords, Records, RunInfo, State
from seoro.bridges.session import Answer, Bound, Mailbox, Request, open_session
from seoro.bridges.wire import CHALLENGE, Challenge, Proof, decode, encode
from seoro.bridges.wire.keys import executor_command
from seoro.concurrency.background import background
from seoro.security.keys.folder import Keys, read_keys
from seoro.security.signing.answers import AnswerSigner
from seoro.security.signing.commands import prove
from seoro.security.signing.statements import certificate_der
from tests.labs import NAME, KeyedLab, make_lab
from tests.relays import Relay, relaying

BOOT = "b00t"
RUN = "0" * 32
KEY = executor_command("default", NAME, "*")
PARTS = 3
INFO = RunInfo(run=RUN, file="x.osc", by="anna", state=State.PASSED, submitted=0.0)


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    return make_lab(tmp_path_factory.mktemp("lab"))


def answer(request: Request, keys: Keys, answers: AnswerSigner) -> None:
    """Reply like an executor."""
    if request.key.endswith(CHALLENGE.name):
        nonce = decode(Challenge, request.payload).nonce
        signature = prove(keys, NAME, nonce, BOOT, 0, answers.exchange)
        certificate = certificate_der(keys.certificate)
        proof = Proof(certificate=certificate, signature=signature, boot=BOOT, now=0, exchange=answers.exchange)
        request.reply(encode(proof))
        return
    for number in range(PARTS):
        request.reply_part(encode(NewRecords(lines=b"%d\n" % number, at=2 * number + 2)))
    request.reply(encode(Records(lines=b"", at=2 * PARTS, is_complete=True, info=INFO)))


async def serve(requests: Mailbox[Request], keys: Keys, answers: AnswerSigner) -> None:
    async for request in requests:
        answer(request, keys, answers)


@asynccontextmanager
async def reached(lab: KeyedLab, folder: Path) -> AsyncIterator[tuple[Relay, Executor]]:
    """Yield an executor behind an attacker who changes its replies."""
    behind, before = (f"unixsock-stream/{folder / name}.sock" for name in ("behind", "before"))
    keys = read_keys(lab.keys(NAME))
    answers = AnswerSigner(keys, BOOT)
    async with (
        open_session(listen=behind) as hub,
        hub.answering(KEY, Bound(100), b"busy", attestor=answers) as requests,
        relaying(before, behind) as relay,
        open_session(connect=before) as session,
        background() as tasks,
    ):
        tasks.start_soon(serve, requests, keys, answers)
        anna = read_keys(lab.keys("anna"))
        yield relay, Executor(session, NAME, messages.MINOR, anna, is_secured=True)


async def reported(executor: Executor) -> list[bytes]:
    """Return the parts of the executor's reply."""
    request = AskRecords(run=RUN, in_parts=True)
    return [each.lines async for each in executor.ask_in_parts(RECORDS, NewRecords, request)]


def at(*numbers: int) -> Callable[[str, list[Answer]], list[Answer]]:
    """Return a change that keeps the given ones of four answers."""

    def change(verb: str, answers: list[Answer]) -> list[Answer]:
        return answers if verb == CHALLENGE.name else [answers[number] for number in numbers]

    return change


@pytest.mark.parametrize(
    ("numbers", "error", "words"),
    [
        ((0, 0, 1, 2, 3), ExecutorLost, "to `records` is not authentic: it was received before"),
        ((0, 1, 0, 2, 3), ExecutorLost, "to `records` is not authentic: it was received before"),
        ((1, 0, 2, 3), Unavailable, "a part of the answer .* to `records` was lost"),
        ((0, 2, 3), Unavailable, "a part of the answer .* to `records` was lost"),
        ((3,), Unavailable, "a part of the answer .* to `records` was lost"),
        ((0, 1, 2), Unavailable, "no server at"),
    ],
)
async def test_parts_of_an_answer_must_arrive_once_in_order_and_completely(
    lab: KeyedLab, tmp_path: Path, numbers: tuple[int, ...], error: type[Exception], words: str
) -> None:
    """A client repeats the request after a lost part."""
    async with reached(lab, tmp_path) as (relay, executor):
        assert await reported(executor) == [b"0\n", b"1\n", b"2\n", b""]
        relay.change = at(*numbers)
        with pytest.raises(error, match=words):
            await reported(executor)


async def test_a_changed_part_of_an_answer_is_refused(lab: KeyedLab, tmp_path: Path) -> None:
    async with reached(lab, tmp_path) as (relay, executor):
        relay.replace(b"1\n", b"2\n", RECORDS.name)
        with pytest.raises(ExecutorLost, match="to `records` is not authentic: invalid signature"):
            await reported(executor)

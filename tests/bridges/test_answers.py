"""Answers in parts that somebody changes on the way: real keys and real sessions."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable
from contextlib import asynccontextmanager
from pathlib import Path

import pytest

from seoro.background import background
from seoro.bridges.executor import messages
from seoro.bridges.executor.asking import Executor, ExecutorLost, Unavailable
from seoro.bridges.executor.messages import RECORDS, AskRecords, NewRecords, Records, RunInfo, State
from seoro.bridges.session import Answer, Bound, Mailbox, Request, open_session
from seoro.bridges.wire import CHALLENGE, Challenge, Proof, decode, encode
from seoro.bridges.wire.keys import executor_command
from seoro.keys.answers import Answers
from seoro.keys.folder import Keys, read_keys
from seoro.keys.sealing import prove
from seoro.keys.signing import certificate_der
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


def answer(request: Request, keys: Keys, answers: Answers) -> None:
    """Answer as an executor does."""
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


async def serve(requests: Mailbox[Request], keys: Keys, answers: Answers) -> None:
    async for request in requests:
        answer(request, keys, answers)


@asynccontextmanager
async def reached(lab: KeyedLab, folder: Path) -> AsyncIterator[tuple[Relay, Executor]]:
    """An executor behind somebody who changes its answers."""
    behind, before = (f"unixsock-stream/{folder / name}.sock" for name in ("behind", "before"))
    keys = read_keys(lab.keys(NAME))
    answers = Answers(keys, BOOT)
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


async def told(executor: Executor) -> list[bytes]:
    """What the executor says, part after part."""
    request = AskRecords(run=RUN, in_parts=True)
    return [each.lines async for each in executor.ask_in_parts(RECORDS, NewRecords, request)]


def at(*numbers: int) -> Callable[[str, list[Answer]], list[Answer]]:
    """Pass on these of four answers."""

    def change(verb: str, answers: list[Answer]) -> list[Answer]:
        return answers if verb == CHALLENGE.name else [answers[number] for number in numbers]

    return change


@pytest.mark.parametrize(
    ("numbers", "error", "words"),
    [
        ((0, 0, 1, 2, 3), ExecutorLost, "to `records` is not authentic: it came before"),
        ((0, 1, 0, 2, 3), ExecutorLost, "to `records` is not authentic: it came before"),
        ((1, 0, 2, 3), Unavailable, "a part of the answer .* to `records` was lost"),
        ((0, 2, 3), Unavailable, "a part of the answer .* to `records` was lost"),
        ((3,), Unavailable, "a part of the answer .* to `records` was lost"),
        ((0, 1, 2), Unavailable, "nobody serves"),
    ],
)
async def test_parts_are_taken_once_in_order_and_all(
    lab: KeyedLab, tmp_path: Path, numbers: tuple[int, ...], error: type[Exception], words: str
) -> None:
    """Who hears that one was lost asks again."""
    async with reached(lab, tmp_path) as (relay, executor):
        assert await told(executor) == [b"0\n", b"1\n", b"2\n", b""]
        relay.change = at(*numbers)
        with pytest.raises(error, match=words):
            await told(executor)


async def test_a_part_that_was_changed_is_refused(lab: KeyedLab, tmp_path: Path) -> None:
    async with reached(lab, tmp_path) as (relay, executor):
        relay.replace(b"1\n", b"2\n", RECORDS.name)
        with pytest.raises(ExecutorLost, match="to `records` is not authentic: the signature is wrong"):
            await told(executor)

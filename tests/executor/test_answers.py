"""Forged and changed answers of executors: real keys, real sessions, a real executor."""

from __future__ import annotations

import hashlib
import json
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from pathlib import Path

import pytest
from anyio.from_thread import start_blocking_portal

import seoro
from seoro.bridges.executor.asking import ExecutorLost
from seoro.bridges.executor.messages import GET_RUN, OneRun, State
from seoro.bridges.session import Answer
from seoro.bridges.wire import Refusal, encode
from seoro.bridges.wire.authentication import DENIED, STALE, UNAVAILABLE
from seoro.cli.main import main
from seoro.client.runs import RemoteRun
from seoro.errors import BackendLost, BackendRefused
from seoro.security.keys import VARIABLE, revocation
from seoro.security.keys.folder import read_keys
from seoro.security.keys.roles import Role
from seoro.security.network.endpoint_keys import security_of
from tests.labs import NAME, KeyedLab, RunningCommand, free_port, keyed_executor, make_lab
from tests.relays import Relay, relaying

FAILING = """import osc.helpers
scenario failing:
    do serial:
        log("begun")
        wait elapsed(20ms)
        emit fail
"""
WRONG = rf"the answer of the executor '{NAME}' to `{{}}` is not authentic: invalid signature"


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> KeyedLab:
    return make_lab(tmp_path_factory.mktemp("lab"))


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("x")


@pytest.fixture(scope="module")
def there(lab: KeyedLab, place: Path) -> Iterator[RunningCommand]:
    with keyed_executor(place, lab) as running:
        yield running


@asynccontextmanager
async def between(lab: KeyedLab, there: RunningCommand, endpoint: str) -> AsyncIterator[Relay]:
    """Yield a router of an attacker."""
    keys = [security_of(endpoint, read_keys(lab.keys(name))) for name in ("hub", "ada")]
    async with relaying(endpoint, there.endpoint, (keys[0], keys[1])) as relay:
        yield relay


Seen = AbstractAsyncContextManager[tuple[Relay, RemoteRun]]
See = Callable[[str], Seen]


@pytest.fixture
def see(lab: KeyedLab, there: RunningCommand, tmp_path: Path) -> See:
    """Return a function that submits a scenario through the router of the attacker."""

    @asynccontextmanager
    async def submitted(text: str) -> AsyncIterator[tuple[Relay, RemoteRun]]:
        file, endpoint = tmp_path / "scenario.osc", f"tls/127.0.0.1:{free_port()}"
        file.write_text(text)
        async with (
            between(lab, there, endpoint) as relay,
            seoro.Client(endpoint, lab.keys("anna")) as client,
        ):
            yield relay, await client.submit(NAME, file)

    return submitted


@asynccontextmanager
async def failed(see: See) -> AsyncIterator[tuple[Relay, RemoteRun]]:
    """Yield a failed run, received through the router."""
    async with see(FAILING) as (relay, run):
        assert not (await run.result()).passed
        yield relay, run


async def test_unchanged_answers_are_accepted(see: See, tmp_path: Path) -> None:
    async with failed(see) as (_, run):
        records = [record async for record in run.records()]
        assert records == [record async for record in run.records_so_far()]
        assert (run.state, len(records) > 3) == (State.FAILED, True)
        assert await run.fetch(tmp_path / "home") == []
        await run.remove()
        with pytest.raises(BackendRefused, match="unknown run"):  # also signed
            await run.remove()


async def test_a_verdict_changed_in_transit_is_detected(see: See) -> None:
    async with failed(see) as (relay, run):
        relay.replace(b"failed", b"passed")
        with pytest.raises(ExecutorLost, match=WRONG.format("get_run")):
            await run.executor.ask(GET_RUN, OneRun(run=run.id))
        with pytest.raises(ExecutorLost, match=WRONG.format("records")):
            [_ async for _ in run.parts()]


def test_the_command_reports_a_changed_answer(
    capsys: pytest.CaptureFixture[str],
    monkeypatch: pytest.MonkeyPatch,
    there: RunningCommand,
    lab: KeyedLab,
    tmp_path: Path,
) -> None:
    """Status 3: the outcome of the run is unknown."""
    monkeypatch.setenv(VARIABLE, str(lab.keys("anna")))
    file, endpoint = tmp_path / "failing.osc", f"tls/127.0.0.1:{free_port()}"
    file.write_text(FAILING)
    with (
        start_blocking_portal() as portal,
        portal.wrap_async_context_manager(between(lab, there, endpoint)) as relay,
    ):
        relay.replace(b"failed", b"passed")
        assert main(["exec", str(file), "--on", NAME, "--executor", endpoint]) == 3
    assert "is not authentic: invalid signature" in capsys.readouterr().err


async def test_unsigned_answers_are_refused(see: See) -> None:
    words = "to `list_files` is not authentic: it is not signed; expected an answer signed with the keys of lab-a"
    async with failed(see) as (relay, run):
        relay.change = lambda _verb, answers: [answer._replace(attachment=b"") for answer in answers]
        with pytest.raises(ExecutorLost, match=words):
            await run.fetch(Path("/nowhere"))
        for code in (STALE, DENIED):
            relay.refuse(encode(Refusal(code=code, message="no")))
            with pytest.raises(ExecutorLost, match="is not authentic: unsigned refusal: no"):
                await run.stop()
        busy = [Answer(False, encode(Refusal(code=UNAVAILABLE, message="busy")))]
        relay.change = lambda _verb, answers: [busy.pop()] if busy else answers
        assert (await run.executor.ask(GET_RUN, OneRun(run=run.id))).info.state is State.FAILED
        assert not busy  # sent before the request is read, so it only costs time


async def test_a_revoked_executor_is_not_trusted(
    there: RunningCommand, lab: KeyedLab, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Connected and new clients with the revocation list refuse it."""
    monkeypatch.setattr(revocation, "PERIOD", 0.0)
    lab.authority.add("nora", Role.OPERATOR, lab.keys("nora"))
    file = tmp_path / "failing.osc"
    file.write_text(FAILING)
    async with seoro.Client(there.endpoint, lab.keys("nora")) as client:
        run = await client.submit(NAME, file)
        await run.result()
        lab.revoke(NAME, "nora")
        with pytest.raises(ExecutorLost, match="is revoked"):
            await run.executor.ask(GET_RUN, OneRun(run=run.id))
    async with seoro.Client(there.endpoint, lab.keys("nora")) as client:
        with pytest.raises(ExecutorLost, match=f"untrusted: the executor '{NAME}': {NAME} .executor. is revoked"):
            await client.submit(NAME, file)


async def test_an_earlier_answer_is_refused(see: See) -> None:
    kept: list[Answer] = []

    def keep(_verb: str, answers: list[Answer]) -> list[Answer]:
        kept.extend(answers)
        return answers

    async with failed(see) as (relay, run):
        relay.change = keep
        assert [record async for record in run.records_so_far()]
        relay.change = lambda _verb, _answers: kept[:1]
        with pytest.raises(ExecutorLost, match=WRONG.format("records")):
            [_ async for _ in run.records_so_far()]


async def test_a_trace_changed_on_disk_is_detected(see: See, place: Path, lab: KeyedLab) -> None:
    """Its hash is in the log of the executor, and its clients compare it."""
    async with failed(see) as (_, run):
        trace = place / "state" / "runs" / run.id / "trace.jsonl"
        recorded = trace.read_bytes()
        found = hashlib.sha256(recorded).hexdigest()
        log = [json.loads(line) for line in (place / "state" / "audit.jsonl").read_bytes().splitlines()]
        [end] = [line for line in log if line["what"] == "run" and line["run"] == run.id]
        assert (run.info.trace, end["trace"]) == (found, found)
        for changed in (recorded.replace(b"begun", b"ended"), recorded[: recorded.rfind(b"\n", 0, -1) + 1]):
            assert changed != recorded
            trace.write_bytes(changed)
            for records in (run.records(), run.records_so_far()):
                with pytest.raises(BackendLost, match=f"was changed after it was recorded: .* expected {found}"):
                    [_ async for _ in records]
        trace.write_bytes(recorded)
        assert [_ async for _ in run.records()]

"""Rejection of unauthorised clients: real keys, real sessions, real processes."""

import asyncio
import hashlib
import json
import os
import re
import secrets
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import anyio
import anyio.to_thread
import pytest

import seoro
from seoro.bridges.executor import messages as wire
from seoro.bridges.session import NoAnswer, NoServer, Refused, Security, Session, SessionError, open_session
from seoro.bridges.wire import encode
from seoro.bridges.wire.authentication import DENIED, Challenge, Proof
from seoro.bridges.wire.keys import executor_command, executor_token
from seoro.bridges.wire.message import decode
from seoro.bridges.wire.refusal import read_refusal
from seoro.bundle.pack import pack
from seoro.embed.options import Options
from seoro.errors import BackendRefused, UsageError
from seoro.security.keys.folder import read_keys
from seoro.security.keys.roles import Role
from seoro.security.network.endpoint_keys import CLIENTS, keys_for, security_of
from seoro.security.signing.audit_log import check_log
from seoro.security.signing.commands import CommandSigner
from tests.executors import HELLO, LONG
from tests.labs import NAME, KeyedLab, RunningCommand, keyed_executor, make_lab

PROGRAM = 'import osc.helpers\nscenario main:\n    do serial:\n        run_process("touch {mark}")\n'
DEADLINE = 30.0  # [s]


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


@pytest.fixture
def file(tmp_path: Path) -> Path:
    path = tmp_path / "hello.osc"
    path.write_text(HELLO)
    return path


def log_of(place: Path, lab: KeyedLab) -> list[dict[str, Any]]:
    """Return the entries of the valid audit log."""
    path = place / "state" / "audit.jsonl"
    check_log(path, read_keys(lab.keys("vera")).authority)
    return [json.loads(line) for line in path.read_bytes().splitlines()]


def refused(place: Path, lab: KeyedLab) -> list[str]:
    return [entry["reason"] for entry in log_of(place, lab) if entry.get("outcome") == "refused"]


async def runs(there: RunningCommand, lab: KeyedLab) -> list[str]:
    async with seoro.Client(there.endpoint, lab.keys("vera")) as client:
        return [run.id for run in await client.runs()]


def security(lab: KeyedLab, name: str, endpoint: str) -> Security | None:
    return security_of(endpoint, keys_for(endpoint, CLIENTS, lab.keys(name)))


async def signer(session: Any, lab: KeyedLab, name: str) -> CommandSigner:
    """Return a signer of a client that ignores its permissions."""
    made, nonce = CommandSigner(read_keys(lab.keys(name)), NAME), secrets.token_bytes(16)
    asked = time.time_ns()
    key = executor_command("default", NAME, "challenge")
    proof = decode(Proof, await session.query(key, encode(Challenge(nonce=nonce)), 5.0))
    statement = (proof.certificate, proof.signature, nonce, proof.boot, proof.now)
    made.accept(*statement, (asked, time.time_ns()), proof.exchange)
    return made


async def test_an_operator_runs_a_scenario(there: RunningCommand, lab: KeyedLab, place: Path, file: Path) -> None:
    async with seoro.Client(there.endpoint, lab.keys("anna")) as client:
        run = await client.submit(NAME, file)
        assert (await run.result()).passed
        assert run.info.by == "anna"
    entries = [entry for entry in log_of(place, lab) if entry.get("run") == run.id]
    lines = [(entry["what"], entry["by"], entry["role"], entry["outcome"]) for entry in entries]
    assert lines[:2] == [("submit", "anna", "operator", outcome) for outcome in ("taken", "done")]
    assert lines[-1] == ("run", "anna", "operator", "passed")
    assert entries[1]["of"] == entries[0]["number"]


async def test_connections_without_a_certificate_are_refused(there: RunningCommand, lab: KeyedLab) -> None:
    with pytest.raises(SessionError):
        Session(connect=there.endpoint)
    with pytest.raises(UsageError, match="contains no keys"):
        async with seoro.Client(there.endpoint, lab.path):
            pass


async def test_unencrypted_connections_are_refused(there: RunningCommand) -> None:
    with pytest.raises(SessionError):
        Session(connect=there.endpoint.replace("tls/", "tcp/"))


async def test_the_token_of_another_executor_ends_no_executor(
    there: RunningCommand, lab: KeyedLab, tmp_path: Path, file: Path
) -> None:
    """The other executor announces a token of the same name with an earlier start."""
    lab.authority.add("lab-b", Role.EXECUTOR, tmp_path / "lab-b")
    keys = read_keys(tmp_path / "lab-b")
    async with (
        open_session(connect=there.endpoint, security=security_of(there.endpoint, keys)) as session,
        session.token(executor_token("default", NAME, "3-000000000000deadbeef")),
        seoro.Client(there.endpoint, lab.keys("anna")) as client,
    ):
        assert (await (await client.submit(NAME, file)).result()).passed
    assert there.process.poll() is None


async def test_keys_of_another_lab_are_refused(there: RunningCommand, tmp_path: Path) -> None:
    other = make_lab(tmp_path, "demo")
    with pytest.raises(UsageError, match="it belongs to another lab"):
        async with seoro.Client(there.endpoint, other.keys("ada")):
            pass


async def test_a_viewer_cannot_submit(there: RunningCommand, lab: KeyedLab, file: Path) -> None:
    before = await runs(there, lab)
    async with seoro.Client(there.endpoint, lab.keys("vera")) as client:
        with pytest.raises(BackendRefused, match=r"vera \(viewer\)"):
            await client.submit(NAME, file)
    assert await runs(there, lab) == before


async def test_an_operator_emits_events_and_a_viewer_receives_them(
    there: RunningCommand, lab: KeyedLab, place: Path, tmp_path: Path
) -> None:
    path = tmp_path / "waiting.osc"
    path.write_text(
        "scenario main:\n    event asks\n    event go\n    do serial:\n        emit asks\n        wait @go\n"
    )
    async with (
        seoro.Client(there.endpoint, lab.keys("anna")) as anna,
        seoro.Client(there.endpoint, lab.keys("vera")) as vera,
    ):
        run = await anna.submit(NAME, path, clock="virtual", external=["go"])
        seen = await vera.run(run.id)
        async with seen.subscribe("asks") as asks:
            await anext(asks)
        with pytest.raises(BackendRefused, match=r"vera \(viewer\)"):
            await seen.emit("go")
        await run.emit("go")
        assert (await seen.result()).passed
    written = [(each["what"], each.get("outcome")) for each in log_of(place, lab) if each.get("run") == run.id]
    assert ("emit_event", "done") in written


async def test_publications_and_tokens_of_a_viewer_are_dropped(there: RunningCommand, lab: KeyedLab) -> None:
    endpoint = there.endpoint
    async with open_session(connect=endpoint, security=security(lab, "vera", endpoint)) as session:
        made = await signer(session, lab, "vera")
        for verb in ("submit", "put_blob", "stop_run", "emit_event", "remove_run", "revoke", "*"):
            key = f"seoro/1/default/exec/{NAME}/cmd/{verb}"
            with pytest.raises(NoServer):
                await session.query(key, b"", 2.0, made.sign(key, b""))
        key = executor_command("default", NAME, "list_runs")
        payload = encode(wire.ListRuns())
        decode(wire.Runs, await session.query(key, payload, 5.0, made.sign(key, payload)))


async def test_a_viewer_cannot_be_an_executor(there: RunningCommand, lab: KeyedLab) -> None:
    endpoint = there.endpoint
    async with (
        open_session(connect=endpoint, security=security(lab, "vera", endpoint)) as session,
        session.token("seoro/1/default/alive/exec/forged/b00t"),
        seoro.Client(endpoint, lab.keys("anna")) as client,
    ):
        assert await client.executors() == [NAME]


async def test_commands_without_a_valid_signature_are_refused(
    there: RunningCommand, lab: KeyedLab, place: Path
) -> None:
    key, payload = executor_command("default", NAME, "list_runs"), encode(wire.ListRuns())
    endpoint = there.endpoint
    async with open_session(connect=endpoint, security=security(lab, "anna", endpoint)) as session:
        made = await signer(session, lab, "anna")
        seal = made.sign(key, payload)
        forged = seal[:-1] + bytes([seal[-1] ^ 1])
        for attachment, reason in (
            (None, "signed commands only"),
            (forged, "invalid signature"),
            (b"x", "invalid signature"),
        ):
            with pytest.raises(Refused) as caught:
                await session.query(key, payload, 5.0, attachment)
            assert read_refusal(caught.value.payload).code == DENIED
            assert any(reason in each for each in refused(place, lab))


async def test_a_replayed_command_is_refused(
    there: RunningCommand, lab: KeyedLab, place: Path, file: Path
) -> None:
    endpoint = there.endpoint
    bundle = pack(seoro.load(file), Options())
    async with seoro.Client(endpoint, lab.keys("anna")) as client:
        run = await client.submit_bundle(NAME, bundle)
        await run.result()
    async with open_session(connect=endpoint, security=security(lab, "anna", endpoint)) as session:
        made = await signer(session, lab, "anna")
        key = executor_command("default", NAME, "submit")
        payload = encode(wire.Submission(run=secrets.token_hex(16), manifest=bundle.manifest))
        seal = made.sign(key, payload)
        await session.query(key, payload, 5.0, seal)
        before = await runs(there, lab)
        with pytest.raises(Refused) as caught:
            await session.query(key, payload, 5.0, seal)
    assert "received before" in read_refusal(caught.value.payload).message
    assert await runs(there, lab) == before
    assert any("received before" in each for each in refused(place, lab))


async def test_an_unknown_run_is_refused(there: RunningCommand, lab: KeyedLab, place: Path) -> None:
    endpoint = there.endpoint
    async with open_session(connect=endpoint, security=security(lab, "ada", endpoint)) as session:
        made = await signer(session, lab, "ada")
        for verb, run in (("stop_run", "f" * 32), ("remove_run", "../../" + "f" * 26), ("read_file", "*")):
            key, payload = executor_command("default", NAME, verb), encode(wire.ListRuns())
            payload = _packed(run=run, path="log.txt")
            with pytest.raises(Refused):
                await session.query(key, payload, 5.0, made.sign(key, payload))
    assert any("unknown run ffff" in each for each in refused(place, lab))


def _packed(**content: object) -> bytes:
    import msgpack

    packed: bytes = msgpack.packb(content)
    return packed


async def test_the_submitter_is_the_name_in_the_certificate(
    there: RunningCommand, lab: KeyedLab, file: Path
) -> None:
    """The submitter of a run comes from the certificate, not from the submission."""
    bundle = pack(seoro.load(file), Options())
    endpoint = there.endpoint
    async with seoro.Client(endpoint, lab.keys("anna")) as client:
        await (await client.submit_bundle(NAME, bundle)).result()
    async with open_session(connect=endpoint, security=security(lab, "anna", endpoint)) as session:
        made, key = await signer(session, lab, "anna"), executor_command("default", NAME, "submit")
        run = secrets.token_hex(16)
        payload = encode(wire.Submission(run=run, manifest=bundle.manifest, by="ada", role="admin"))
        info = decode(wire.RunInfo, await session.query(key, payload, 5.0, made.sign(key, payload)))
    assert (info.run, info.by) == (run, "anna")


async def test_an_operator_cannot_start_programs(
    there: RunningCommand, lab: KeyedLab, place: Path, tmp_path: Path
) -> None:
    mark, file = tmp_path / "mark", tmp_path / "program.osc"
    file.write_text(PROGRAM.format(mark=mark))
    async with seoro.Client(there.endpoint, lab.keys("anna")) as client:
        run = await client.submit(NAME, file)
        with pytest.raises(seoro.InvalidScenario):
            await run.result()
    assert not mark.exists()
    last = next(entry for entry in reversed(log_of(place, lab)) if entry.get("run") == run.id)
    assert (last["what"], last["outcome"]) == ("run", "invalid")
    assert "does not allow `run_process`" in last["reason"]


@pytest.mark.parametrize("path", ["../mark", "a/../../mark", "/tmp/mark", "a\\..\\mark", "a/./b", "a//b"])
async def test_a_bundle_with_paths_out_of_its_folder_is_refused(
    there: RunningCommand, lab: KeyedLab, place: Path, file: Path, path: str
) -> None:
    bundle = pack(seoro.load(file), Options())
    async with seoro.Client(there.endpoint, lab.keys("anna")) as client:
        await (await client.submit_bundle(NAME, bundle)).result()  # its blobs are there now
        before = await runs(there, lab)
        files = tuple(each.model_copy(update={"path": path}) for each in bundle.manifest.files)
        manifest = bundle.manifest.model_copy(update={"files": files, "entry": path})
        with pytest.raises(BackendRefused, match="cannot store the bundle"):
            await client.submit_bundle(NAME, type(bundle)(manifest, bundle.blobs))
    assert await runs(there, lab) == before
    entries = log_of(place, lab)
    last = next(entry for entry in reversed(entries) if "cannot store the bundle" in entry.get("reason", ""))
    assert (last["outcome"], entries[last["of"]]["outcome"]) == ("refused", "taken")
    assert entries[last["of"]]["request"] == last["request"]


async def test_wrong_blob_sizes_are_refused(there: RunningCommand, lab: KeyedLab, place: Path) -> None:
    data = os.urandom(1000)
    digest = hashlib.sha256(data).hexdigest()
    lies = {
        "longer than announced": {"hash": digest, "size": 10, "offset": 0, "data": data},
        "expected byte 0": {"hash": digest, "size": 1 << 20, "offset": 1 << 19, "data": data},
        "does not match its hash": {"hash": "0" * 64, "size": 1000, "offset": 0, "data": data},
        "less than or equal to": {"hash": digest, "size": 1 << 40, "offset": 0, "data": data},
    }
    endpoint = there.endpoint
    async with open_session(connect=endpoint, security=security(lab, "anna", endpoint)) as session:
        made, key = await signer(session, lab, "anna"), executor_command("default", NAME, "put_blob")
        for reason, content in lies.items():
            payload = _packed(**content)
            with pytest.raises(Refused) as caught:
                await session.query(key, payload, 5.0, made.sign(key, payload))
            assert reason in read_refusal(caught.value.payload).message
            assert any(reason in each for each in refused(place, lab))
    blobs = [path for path in (place / "state" / "blobs").iterdir() if path.name.startswith((digest, "000"))]
    assert all(path.suffix == ".part" for path in blobs)


def memory(process: int) -> int:
    """Return the peak memory of a process [MiB]."""
    status = Path(f"/proc/{process}/status").read_text()
    found = re.search(r"VmHWM:\s+(\d+) kB", status)
    assert found is not None
    return int(found[1]) // 1024


async def test_a_too_large_message_takes_little_memory(there: RunningCommand, lab: KeyedLab) -> None:
    before = memory(there.process.pid)
    script = f"""
import asyncio
from pathlib import Path
from seoro.security.network.endpoint_keys import CLIENTS, keys_for, security_of
from seoro.bridges.session import NoAnswer, open_session

async def main():
    keys = keys_for({there.endpoint!r}, CLIENTS, Path({str(lab.keys("ada"))!r}))
    async with open_session(connect={there.endpoint!r}, security=security_of({there.endpoint!r}, keys)) as session:
        try:
            await session.query({executor_command("default", NAME, "submit")!r}, bytes(1 << 28), 2.0)
        except NoAnswer:
            print("no answer")

asyncio.run(main())
"""
    sent = await anyio.run_process([sys.executable, "-c", script], stderr=subprocess.STDOUT)
    assert b"no answer" in sent.stdout, sent.stdout
    assert memory(there.process.pid) - before < 128  # of 256
    await runs(there, lab)  # it still answers


async def test_the_wire_has_no_readable_names_and_texts(
    there: RunningCommand, lab: KeyedLab, tmp_path: Path
) -> None:
    """A proxy between both ends records all bytes; they contain no names or texts of scenarios."""
    secret = "the-robot-goes-to-the-vault"
    file = tmp_path / f"{secret}.osc"
    file.write_text(HELLO.replace('"hello"', f'"{secret}"'))
    seen = bytearray()
    port = int(there.endpoint.rpartition(":")[2])

    async def pass_on(source: asyncio.StreamReader, to: asyncio.StreamWriter) -> None:
        while data := await source.read(1 << 16):
            seen.extend(data)
            to.write(data)
        to.close()

    async def connected(reader: asyncio.StreamReader, writer: asyncio.StreamWriter) -> None:
        there_reader, there_writer = await asyncio.open_connection("127.0.0.1", port)
        await asyncio.gather(pass_on(reader, there_writer), pass_on(there_reader, writer), return_exceptions=True)

    proxy = await asyncio.start_server(connected, "127.0.0.1", 0)
    endpoint = f"tls/127.0.0.1:{proxy.sockets[0].getsockname()[1]}"
    async with seoro.Client(endpoint, lab.keys("anna")) as client:
        run = await client.submit(NAME, file)
        logs = [record["message"] async for record in run.records() if record["kind"] == "log"]
    proxy.close()
    assert logs == [secret]
    assert len(seen) > 10_000
    assert secret.encode() not in seen
    assert b"seoro/1/" not in seen


async def test_revoked_keys_are_disconnected_at_once(lab: KeyedLab, tmp_path: Path, file: Path) -> None:
    """Connected clients are rejected, too; others continue without a loss."""
    lab.authority.add("rob", read_keys(lab.keys("anna")).identity.role, lab.keys("rob"))
    file.write_text(LONG.replace("60s", "3s"))
    with keyed_executor(tmp_path, lab) as there:
        async with (
            seoro.Client(there.endpoint, lab.keys("anna")) as anna,
            seoro.Client(there.endpoint, lab.keys("rob")) as rob,
        ):
            run = await rob.submit(NAME, file)
            seen = await anna.run(run.id)
            lab.revoke("rob", NAME)
            began = time.monotonic()
            watched = [record["seq"] async for record in seen.records()]
            assert watched == list(range(len(watched)))
            run.executor.patience = 0.5
            with pytest.raises(seoro.BackendError):
                await run.stop()
            assert time.monotonic() - began < DEADLINE
        with pytest.raises(UsageError, match="clients with revoked keys see no executors"):
            async with seoro.Client(there.endpoint, lab.keys("rob")) as rob:
                await rob.submit(NAME, file)
        lab.authority.revoke("vera")
        lab.authority.add("vera", read_keys(lab.keys("vera")).identity.role, lab.path / "vera-again")


async def test_a_session_without_rights_receives_no_reply(
    there: RunningCommand, lab: KeyedLab, file: Path
) -> None:
    endpoint = there.endpoint
    keys = read_keys(lab.keys("hub"))
    async with open_session(connect=endpoint, security=security_of(endpoint, keys)) as session:
        assert await session.list_tokens("seoro/**", 1.0) == frozenset()
        with pytest.raises((NoServer, NoAnswer)):
            await session.query(executor_command("default", NAME, "list_runs"), encode(wire.ListRuns()), 1.0)

"""Clients of executors over real sessions, with and without dying processes."""

import asyncio
import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import AsyncExitStack
from pathlib import Path
from typing import Any

import anyio
import anyio.to_thread
import pytest

import seoro
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import State
from seoro.bundle.pack import pack
from seoro.client.runs import RemoteRun
from seoro.embed.options import Options
from seoro.errors import BackendRefused
from tests.executors import HELLO, LONG, MANY, NAME, RunningExecutor, executor

DEADLINE = 30.0  # [s]


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("x"), "--jobs", "3") as running:
        yield running


def write(folder: Path, text: str, name: str = "test.osc") -> Path:
    path = folder / name
    path.write_text(text)
    return path


async def all_records(run: RemoteRun) -> list[dict[str, Any]]:
    return [record async for record in run.records()]


def check_sequence(records: list[dict[str, Any]]) -> None:
    """Assert that no record is lost or repeated."""
    assert [record["seq"] for record in records] == list(range(len(records)))


async def wait_for(run: RemoteRun, state: State) -> None:
    async for info, _ in run.parts():
        if info.state is state:
            return
    assert run.state is state


async def test_a_submitted_scenario_runs_to_its_verdict(lab: RunningExecutor, tmp_path: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, write(tmp_path, HELLO), seed=7)
        records = await all_records(run)
        verdict = await run.result()
    assert verdict.passed
    assert verdict.seed == 7
    check_sequence(records)
    assert (records[0]["kind"], records[-1]["kind"]) == ("run.start", "run.end")
    assert [record["message"] for record in records if record["kind"] == "log"] == ["hello"]


async def test_a_remote_run_has_the_trace_of_a_local_run(lab: RunningExecutor, tmp_path: Path) -> None:
    file = write(tmp_path, MANY)
    here: list[dict[str, Any]] = []

    class Keep:
        def record(self, record: dict[str, Any]) -> None:
            here.append(record)

    async with seoro.start(seoro.load(file), seed=3, clock="virtual", observers=[Keep()]) as started:
        await started.result()
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, file, seed=3, clock="virtual")
        there = await all_records(run)

    def comparable(records: list[dict[str, Any]]) -> list[Any]:
        plain = json.loads(json.dumps(records))
        return [{key: value for key, value in each.items() if key != "wall"} for each in plain]

    assert comparable(there) == comparable(here)


async def test_a_failed_run_has_its_reason_and_position(lab: RunningExecutor, tmp_path: Path) -> None:
    text = "import osc.helpers\nscenario broken:\n    do serial:\n        emit fail\n"
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, write(tmp_path, text))
        verdict = await run.result()
    assert verdict.status is seoro.RunStatus.FAILED
    assert verdict.span is not None
    assert verdict.span.line == 4
    assert run.state is State.FAILED


async def test_invalid_submissions_are_refused_by_the_client(lab: RunningExecutor, tmp_path: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        before = len(await client.runs())
        with pytest.raises(seoro.InvalidScenario):
            await client.submit(NAME, write(tmp_path, "scenario main:\n    do nothing()\n"))
        with pytest.raises(seoro.UsageError, match="rate"):
            await client.submit(NAME, write(tmp_path, HELLO), simulator=seoro.Simulator(name="mujoco", rate=-1.0))
        assert len(await client.runs()) == before


async def test_forbidden_behaviors_make_a_scenario_invalid(lab: RunningExecutor, tmp_path: Path) -> None:
    mark = tmp_path / "mark"
    text = f'import osc.helpers\nscenario main:\n    do serial:\n        run_process("touch {mark}")\n'
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, write(tmp_path, text))
        with pytest.raises(seoro.InvalidScenario) as caught:
            await run.result()
        assert run.state is State.INVALID
    assert caught.value.diagnostics[0].primary.span.line == 4
    assert not mark.exists()


async def test_a_repeated_submission_is_one_run(lab: RunningExecutor, tmp_path: Path) -> None:
    bundle = pack(seoro.load(write(tmp_path, HELLO)), Options())
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit_bundle(NAME, bundle)
        again = wire.Submission(run=run.id, manifest=bundle.manifest)
        infos = await asyncio.gather(*(run.executor.ask(wire.SUBMIT, again) for _ in range(5)))
        assert {info.run for info in infos} == {run.id}
        await run.result()
        await run.executor.ask(wire.SUBMIT, again)  # also after its end
        assert run.state is State.PASSED
        assert [each.id for each in await client.runs() if each.id == run.id] == [run.id]
        starts = [record for record in await all_records(run) if record["kind"] == "run.start"]
    assert len(starts) == 1


async def test_a_second_bundle_uploads_no_file_again(lab: RunningExecutor, tmp_path: Path) -> None:
    bundle = pack(seoro.load(write(tmp_path, HELLO + "# another\n")), Options())
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit_bundle(NAME, bundle)
        missing = await run.executor.ask(wire.MISSING_BLOBS, wire.Hashes(hashes=tuple(bundle.blobs)))
        await run.result()
    assert missing.hashes == ()


async def test_a_forged_bundle_is_refused_and_nothing_runs(lab: RunningExecutor, tmp_path: Path) -> None:
    bundle = pack(seoro.load(write(tmp_path, HELLO)), Options())
    [file] = bundle.manifest.files
    evil = bundle.manifest.model_copy(update={"files": (file, file.model_copy(update={"path": "../../evil.osc"}))})
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit_bundle(NAME, bundle)
        with pytest.raises(BackendRefused, match="cannot store the bundle"):
            await run.executor.ask(wire.SUBMIT, wire.Submission(run="e" * 32, manifest=evil))
        with pytest.raises(seoro.UsageError, match="unknown run"):
            await client.run("e" * 32)
    assert not list(lab.folder.rglob("evil.osc"))


async def test_files_outside_of_the_output_folder_are_not_read(lab: RunningExecutor, tmp_path: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, write(tmp_path, HELLO))
        await run.result()
        for path in ("../files/test.osc", "/etc/passwd", "nothing"):
            with pytest.raises(BackendRefused):
                await run.executor.ask(wire.READ_FILE, wire.ReadFile(run=run.id, path=path))


async def test_a_run_is_stopped_and_cleans_up(lab: RunningExecutor, tmp_path: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, write(tmp_path, LONG))
        await wait_for(run, State.RUNNING)
        await run.stop("enough")
        with anyio.fail_after(DEADLINE):
            verdict = await run.result()
        assert (verdict.status, verdict.reason) == (seoro.RunStatus.CANCELLED, "enough")
        assert run.state is State.CANCELLED
        await run.stop()  # of no effect
        await run.remove()
        with pytest.raises(BackendRefused, match="unknown run"):
            await run.stop()


async def test_an_active_run_is_not_removed(lab: RunningExecutor, tmp_path: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, write(tmp_path, LONG))
        with pytest.raises(BackendRefused, match="stop it first"):
            await run.remove()
        await run.stop()
        await run.result()


async def test_a_run_whose_process_is_killed_is_an_error(lab: RunningExecutor, tmp_path: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, write(tmp_path, LONG))
        async for record in run.records():
            if record["kind"] == "log":
                break
        os.kill(worker_of(lab, run), signal.SIGKILL)
        with anyio.fail_after(DEADLINE), pytest.raises(seoro.BackendError, match="killed by signal 9"):
            await run.result()
        assert run.state is State.ERROR
        check_sequence(await all_records(run))


def worker_of(lab: RunningExecutor, run: RemoteRun) -> int:
    """Return the process of a run, found by its working directory; it may be in a sandbox."""
    folder = lab.folder / "state" / "runs" / run.id / "files"
    [template] = children_of(lab.process.pid)  # the process that makes those of runs
    below = children_of(template)
    for pid in below:  # it grows
        below += children_of(pid)
    [found] = [pid for pid in below if Path(f"/proc/{pid}/cwd").readlink() == folder]
    return found


def children_of(pid: int) -> list[int]:
    return [int(child) for child in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]


async def test_runs_without_their_client_are_stopped_on_request(lab: RunningExecutor, tmp_path: Path) -> None:
    file = write(tmp_path, LONG)
    async with seoro.Client(lab.endpoint) as client:
        other = await client.submit(NAME, file)
        run = await client.submit(NAME, file, stop_if_lost=1.0)
        await wait_for(run, State.RUNNING)
    async with seoro.Client(lab.endpoint) as client:  # listing runs does not count for `stop_if_lost`
        with anyio.fail_after(DEADLINE):
            verdict = await (await client.run(run.id)).result()
        assert verdict.status is seoro.RunStatus.CANCELLED
        assert "lost its client for 1 s" in verdict.reason
        found = await client.run(other.id)
        assert not found.state.is_final
        await found.stop()
        await found.result()


async def test_a_watched_run_continues(lab: RunningExecutor, tmp_path: Path) -> None:
    text = "import osc.helpers\nscenario short:\n    do serial:\n        wait elapsed(1.6s)\n"
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, write(tmp_path, text), stop_if_lost=1.0)
        assert (await run.result()).passed


_WATCHER = """
import anyio, json, sys, seoro
async def main(endpoint, run):
    async with seoro.Client(endpoint) as client:
        found = await client.run(run)
        async for record in found.records():
            print(record["seq"], flush=True)
anyio.run(main, *sys.argv[1:])
"""


async def test_a_suspended_watcher_delays_no_run_and_misses_no_record(
    lab: RunningExecutor, tmp_path: Path
) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, write(tmp_path, MANY))
        watcher = await asyncio.create_subprocess_exec(
            sys.executable, "-c", _WATCHER, lab.endpoint, run.id, stdout=subprocess.PIPE
        )
        assert watcher.stdout is not None
        first = await watcher.stdout.readline()
        watcher.send_signal(signal.SIGSTOP)
        began = time.monotonic()
        records = await all_records(run)
        verdict = await run.result()
        assert time.monotonic() - began < 2 * DEADLINE
        assert verdict.passed
        watcher.send_signal(signal.SIGCONT)
        with anyio.fail_after(DEADLINE):
            rest = await watcher.stdout.read()
        await watcher.wait()
    check_sequence(records)
    assert list(map(int, (first + rest).split())) == list(range(len(records)))


async def test_a_late_watcher_receives_all_records(lab: RunningExecutor, tmp_path: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        run = await client.submit(NAME, write(tmp_path, MANY), clock="virtual")
        await run.result()
        first, second = await all_records(run), await all_records(await client.run(run.id[:12]))
    check_sequence(first)
    assert first == second
    assert len(first) > 300


async def test_unknown_executors_and_runs_are_refused(lab: RunningExecutor, tmp_path: Path) -> None:
    async with seoro.Client(lab.endpoint) as client:
        with pytest.raises(seoro.UsageError, match="unknown executor 'lab-b'") as caught:
            await client.submit("lab-b", write(tmp_path, HELLO))
        assert caught.value.help == f"executors: {NAME}"
        with pytest.raises(seoro.UsageError, match="invalid id"):
            await client.run("xyz")
        with pytest.raises(seoro.UsageError, match="unknown run '000000000'"):
            await client.run("000000000")


async def test_an_unreachable_executor_is_reported(tmp_path: Path) -> None:
    with pytest.raises(seoro.UsageError, match="nothing answers"):
        async with seoro.Client(f"unixsock-stream/{tmp_path}/nobody"):
            pass
    with pytest.raises(seoro.UsageError, match="not open"):
        await seoro.Client().runs()


# ---------------------------------------------------------------- the executor dies


@pytest.mark.more
async def test_a_restarted_executor_continues_its_queue(tmp_path: Path) -> None:
    async with anyio.create_task_group() as tasks:
        with executor(tmp_path) as lab:
            async with seoro.Client(lab.endpoint) as client:
                run = await client.submit(NAME, write(tmp_path, LONG))
                waiting = await client.submit(NAME, write(tmp_path, HELLO, "hello.osc"))
                async for record in run.records():
                    if record["kind"] == "log":
                        break
                process = worker_of(lab, run)
                lab.kill()
                with anyio.fail_after(DEADLINE):
                    while Path(f"/proc/{process}/exe").exists():  # its pipe closes, and it stops its run
                        await anyio.sleep(0.02)
                seen = anyio.Event()
                tasks.start_soon(_come_back, tmp_path, seen)
                with anyio.fail_after(DEADLINE):  # this client asks until there is an executor again
                    with pytest.raises(seoro.BackendError, match="lost"):
                        await run.result()
                    assert (await waiting.result()).passed
                check_sequence(await all_records(run))
                seen.set()


async def _come_back(folder: Path, seen: anyio.Event) -> None:
    with executor(folder):
        await seen.wait()


@pytest.mark.more
async def test_an_unwritable_trace_ends_its_run_as_an_error_and_spares_the_next_run(tmp_path: Path) -> None:
    with executor(tmp_path, largest=200_000) as lab:
        async with seoro.Client(lab.endpoint) as client:
            file = write(tmp_path, MANY.replace("3s", "60s"))
            run = await client.submit(NAME, file, clock="virtual")
            with (
                anyio.fail_after(DEADLINE),
                pytest.raises(seoro.BackendError, match="cannot store the run: File too large"),
            ):
                await run.result()
            check_sequence(await all_records(run))
            other = await client.submit(NAME, write(tmp_path, HELLO, "hello.osc"))
            with anyio.fail_after(DEADLINE):
                assert (await other.result()).passed


@pytest.mark.more
async def test_a_stopped_executor_stops_its_runs_and_keeps_its_queue(tmp_path: Path) -> None:
    async with AsyncExitStack() as stack:
        with executor(tmp_path) as lab:
            client = await stack.enter_async_context(seoro.Client(lab.endpoint))
            tasks = await stack.enter_async_context(anyio.create_task_group())
            run = await client.submit(NAME, write(tmp_path, LONG))
            waiting = await client.submit(NAME, write(tmp_path, HELLO, "hello.osc"))
            await wait_for(run, State.RUNNING)
            watching = asyncio.ensure_future(waiting.result())  # asks until there is an executor again
            tasks.start_soon(anyio.to_thread.run_sync, lab.end)
            assert (await run.result()).reason == "the executor was stopped"
            await asyncio.to_thread(lab.process.wait, DEADLINE)
        assert lab.process.returncode == 0
        with executor(tmp_path), anyio.fail_after(DEADLINE):
            assert (await watching).passed
            assert (await client.run(run.id)).state is State.CANCELLED

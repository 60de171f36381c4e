"""Processes that scenarios start: their output, their ends, and that nothing of them is left."""

import asyncio
import os
import signal
import threading
from collections.abc import Iterator
from pathlib import Path

import anyio
import pytest

from seoro.actions import processes
from seoro.embed.options import Options
from seoro.runtime.verdict import RunStatus
from tests.integration.conftest import is_alive, wait_until
from tests.runtime.conftest import Prepare, RunText

REAL = Options(clock="real", grace=1.0)


def children() -> set[int]:
    """Living children of this process."""
    found = set()
    for entry in Path("/proc").iterdir():
        if entry.name.isdecimal():
            try:
                state, parent = (entry / "stat").read_text().rpartition(")")[2].split()[:2]
            except OSError:
                continue
            if int(parent) == os.getpid() and state != "Z":
                found.add(int(entry.name))
    return found


def open_files() -> int:
    """Return the number of open files of this process."""
    return len(list(Path("/proc/self/fd").iterdir()))


@pytest.fixture(autouse=True)
def _nothing_is_left() -> Iterator[None]:
    """A run leaves no process, no open file and no thread."""
    files, threads = open_files(), threading.active_count()
    before = children()
    yield
    assert children() == before
    wait_until(lambda: threading.active_count() <= threads, 30.0)  # asyncio waits for processes in threads
    assert open_files() <= files


def pids(path: Path, count: int) -> list[int]:
    """Process ids that a program has written, once there are so many."""
    wait_until(lambda: path.exists() and path.read_text().count("\n") == count, 30.0)
    return [int(line) for line in path.read_text().split()]


async def test_output_is_logged_line_by_line(run_text: RunText) -> None:
    ran = await run_text(
        "scenario main:\n"
        "    do serial:\n"
        "        run_process(\"sh -c 'echo one; echo two >&2; printf three'\")\n"
        "        log('then')\n"
    )
    assert ran.verdict.passed, ran.verdict.reason
    lines = [line for _, line in ran.logs]
    assert sorted(lines[:3]) == ["one", "three", "two"]
    assert lines[3] == "then"
    [one] = [record for record in ran.records if record.get("message") == "one"]
    assert (one["level"], one["source"].rpartition("test.osc")[2]) == ("info", ":6:9")


async def test_quotes_make_words_and_nothing_is_expanded(run_text: RunText) -> None:
    ran = await run_text("""scenario main:\n    do run_process("echo 'a  b' $HOME * | ;")\n""")
    assert [line for _, line in ran.logs] == ["a  b $HOME * | ;"]


@pytest.mark.parametrize(
    ("command", "reason"),
    [
        ("sh -c 'echo one; echo; echo two >&2; exit 3'", "`sh` ended with exit status 3\n  one\n  two"),
        ("sh -c 'kill -SEGV $$'", "`sh` was killed by SIGSEGV"),
        ("no-such-program -x", "unknown program `no-such-program`: not found in the folders of `PATH`"),
        ("./no/such/file", "unknown program `./no/such/file`: no such file"),
        ("/", "cannot start the program `/`: Permission denied"),
        ("", "invalid command ``; expected a program and its arguments"),
        ("echo 'a", "cannot split the command `echo 'a` into words: No closing quotation"),
    ],
)
async def test_a_failed_process_is_reported_with_its_reason(command: str, reason: str, run_text: RunText) -> None:
    ran = await run_text(f'scenario main:\n    do run_process("{command}")\n')
    assert ran.verdict.status is RunStatus.FAILED
    assert ran.verdict.reason == f"`run_process` failed: {reason}"


async def test_the_label_is_the_name_of_the_process(run_text: RunText) -> None:
    ran = await run_text("scenario main:\n    do build: run_process('false')\n")
    assert ran.verdict.reason == "`run_process` failed: `build` ended with exit status 1"


async def test_virtual_time_waits_for_a_process_but_not_in_the_background(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do parallel:
        run_process("sleep 0.1")
        serial:
            run_process("sleep 1000", wait_for_shutdown: false)
            wait elapsed(500s)
        serial:
            wait elapsed(1s)
            log("after")
""")
    assert ran.verdict.passed, ran.verdict.reason
    assert ran.logs == [(1.0, "after")]
    assert ran.verdict.duration == 500.0
    assert ran.verdict.wall_duration < 60


FORKS = """#!/bin/sh
echo $$ >> pids
(setsid sh -c 'echo $$ >> pids; exec sleep 1000' &)
sleep 1000 &
echo $! >> pids
wait
"""


@pytest.mark.parametrize("wait", ["true", "false"])
async def test_child_processes_end_with_their_process(
    wait: str, prepare_text: Prepare, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "forks").write_text(FORKS)
    (tmp_path / "forks").chmod(0o755)
    text = f"""
scenario main:
    do serial:
        run_process("./forks", wait_for_shutdown: {wait})
        wait elapsed(1h)
"""
    async with prepare_text(text, REAL) as run, run.running():
        found = await anyio.to_thread.run_sync(pids, tmp_path / "pids", 3)
        assert all(is_alive(pid) for pid in found)
        run.stop("enough")
        verdict = await run.result()
    assert not any(is_alive(pid) for pid in found)
    assert verdict.status is RunStatus.CANCELLED
    assert not any(each.overran for each in verdict.cancelled)


async def test_background_processes_live_until_the_end_of_the_run(prepare_text: Prepare, tmp_path: Path) -> None:
    written = tmp_path / "pids"
    text = f"""
scenario main:
    do serial:
        run_process("sh -c 'sleep 1000 & echo $! > {written}'")
        log("left")
        wait elapsed(1h)
"""
    async with prepare_text(text, REAL) as run, run.running():
        async for record in run.trace():
            if record["kind"] == "log":
                break
        [left] = pids(written, 1)
        assert is_alive(left)
        run.stop("enough")
        await run.result()
    assert not is_alive(left)


async def test_a_process_that_ignores_its_signal_is_killed_after_its_timeout(prepare_text: Prepare) -> None:
    text = """
scenario main:
    do serial:
        stubborn: run_process("sh -c 'trap \\"\\" TERM; echo on; while true; do sleep 0.01; done'",
            wait_for_shutdown: false, shutdown_timeout: 0.3s)
        process_log_check("stubborn", ["on"])
"""
    async with prepare_text(text, REAL) as run, run.running():
        verdict = await run.result()
    assert verdict.passed, verdict.reason
    [cancelled] = verdict.cancelled
    assert cancelled.path.endswith("stubborn[0]")
    assert 0.3 <= cancelled.clean_up < 1.3
    assert not cancelled.overran


async def test_remaining_children_of_an_ended_process_are_signalled(prepare_text: Prepare) -> None:
    text = """
scenario main:
    do serial:
        old: run_process("sh -c 'trap \\"setsid sleep 1000 & exit\\" TERM; echo on; while :; do sleep 0.01; done'",
            wait_for_shutdown: false)
        process_log_check("old", ["on"])
"""
    async with prepare_text(text, REAL) as run, run.running():
        verdict = await run.result()
    [cancelled] = verdict.cancelled
    assert cancelled.clean_up < 5.0  # it would be killed after 10 s


async def test_a_process_that_becomes_another_program_is_signalled_again(
    prepare_text: Prepare, tmp_path: Path
) -> None:
    script = tmp_path / "leaves.sh"
    script.write_text("""
trap '(trap "" TERM; sleep 0.3; trap - TERM; exec sleep 1000) & exit' TERM
echo on
while :; do sleep 0.01; done
""")
    text = f"""
scenario main:
    do serial:
        old: run_process("sh {script}", wait_for_shutdown: false)
        process_log_check("old", ["on"])
"""
    async with prepare_text(text, REAL) as run, run.running():
        verdict = await run.result()
    [cancelled] = verdict.cancelled
    assert cancelled.clean_up < 5.0  # it would be killed after 10 s


async def test_a_process_receives_the_requested_signal(prepare_text: Prepare) -> None:
    text = """
scenario main:
    do serial:
        server: run_process("sh -c 'trap \\"echo stopped; exit\\" INT; echo on; while true; do sleep 0.01; done'",
            wait_for_shutdown: false, shutdown_signal: signal!sigint)
        process_log_check("server", ["on"])
"""
    async with prepare_text(text, REAL) as run, run.running():
        logs = [record["message"] async for record in run.trace() if record["kind"] == "log"]
    assert logs == ["on", "stopped"]


async def test_a_failed_background_process_is_a_warning(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do serial:
        server: run_process("sh -c 'exit 4'", wait_for_shutdown: false)
        process_log_check("server", ["on"])
""")
    assert ran.verdict.reason == (
        "`process_log_check` failed: `server` ended with exit status 4 without 'on' in its output"
    )
    [warning] = [record["message"] for record in ran.records if record.get("level") == "warning"]
    assert warning == "`server` ended with exit status 4"


@pytest.mark.parametrize("is_swapped", [False, True])
async def test_a_log_check_waits_for_its_process(is_swapped: bool, run_text: RunText) -> None:
    members = [
        "serial:\n            wait elapsed(1s)\n            server: run_process(\"sh -c 'echo a; echo b'\")",
        'process_log_check("server", ["x", "b"])',
    ]
    first, second = members[::-1] if is_swapped else members
    ran = await run_text(f"scenario main:\n    do parallel:\n        {first}\n        {second}\n")
    assert ran.verdict.passed, ran.verdict.reason


@pytest.mark.parametrize("is_swapped", [False, True])
async def test_a_log_check_in_a_repetition_uses_its_own_process(
    is_swapped: bool, run_text: RunText, tmp_path: Path
) -> None:
    program = f"sh -c 'test -e {tmp_path}/flag || echo ready; touch {tmp_path}/flag'"
    members = [f'server: run_process("{program}")', 'process_log_check("server", ["ready"])']
    first, second = members[::-1] if is_swapped else members
    text = f"scenario main:\n    do parallel:\n        {first}\n        {second}\n    with:\n        repeat(2)\n"
    ran = await run_text(text)
    assert ran.verdict.reason == (
        "`process_log_check` failed: `server` ended with exit status 0 without 'ready' in its output"
    )


@pytest.mark.parametrize(("from_start", "status"), [("true", "passed"), ("false", "failed")])
async def test_a_log_check_includes_earlier_output_on_request(
    from_start: str, status: str, run_text: RunText
) -> None:
    ran = await run_text(f"""
scenario main:
    do serial:
        server: run_process("echo ready")
        process_log_check("server", ["read"], from_start: {from_start})
""")
    assert ran.verdict.status.value == status


async def test_a_log_check_of_an_unknown_process_lists_the_running_ones(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do parallel:
        server: run_process("true")
        process_log_check("sever", ["x"])
""")
    assert "unknown process `sever` (labels of programs: server)" in ran.verdict.reason


async def test_the_kept_output_of_a_process_is_bounded(run_text: RunText, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(processes, "MAX_LOGGED", 10)
    monkeypatch.setattr(processes, "MAX_KEPT", 1_000)
    monkeypatch.setattr(processes, "MAX_LINE", 100)
    ran = await run_text("""
scenario main:
    do parallel:
        many: run_process("sh -c 'seq 100000; head -c 100000 /dev/zero; echo; echo last'")
        process_log_check("many", ["99999"])
""")
    assert ran.verdict.passed, ran.verdict.reason
    logs = [line for _, line in ran.logs]
    assert logs[:10] == [str(number) for number in range(1, 11)]
    assert logs[10:] == ["`many` has written 10 lines; further lines are not logged"]


async def test_a_cancelled_task_leaves_no_processes(prepare_text: Prepare, tmp_path: Path) -> None:
    written = tmp_path / "pids"
    text = f"scenario main:\n    do run_process(\"sh -c 'echo $$ > {written}; sleep 1000'\")\n"

    async def carry() -> None:
        async with prepare_text(text, REAL) as run, run.running():
            await run.result()

    task = asyncio.create_task(carry())
    [pid] = await anyio.to_thread.run_sync(pids, written, 1)
    task.cancel()
    with pytest.raises(asyncio.CancelledError):
        await task
    assert not is_alive(pid)


async def test_a_killed_supervisor_takes_its_process_along(prepare_text: Prepare, tmp_path: Path) -> None:
    written = tmp_path / "pids"
    text = f"scenario main:\n    do run_process(\"sh -c 'echo $$ > {written}; sleep 1000'\")\n"
    before = children()
    async with prepare_text(text, REAL) as run, run.running():
        [pid] = await anyio.to_thread.run_sync(pids, written, 1)
        [supervisor] = children() - before
        os.kill(supervisor, signal.SIGKILL)
        verdict = await run.result()
    assert verdict.reason == "`run_process` failed: `sh` was killed by SIGKILL"
    wait_until(lambda: not is_alive(pid), 30.0)


async def test_an_ended_process_is_not_cancelled_at_the_end(run_text: RunText) -> None:
    ran = await run_text("scenario main:\n    do run_process('true') with:\n        repeat(5)\n")
    assert ran.verdict.passed
    assert ran.verdict.cancelled == ()


async def test_a_process_may_close_its_output_and_continue(run_text: RunText) -> None:
    ran = await run_text("""
scenario main:
    do serial:
        server: run_process("sh -c 'exec >&- 2>&-; exec sleep 100'", wait_for_shutdown: false)
        process_log_check("server", ["on"])
""")
    assert (
        ran.verdict.reason == "`process_log_check` failed: `server` closed its output without 'on' in its output"
    )

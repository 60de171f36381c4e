"""Resource limits of runs; each message names the limit, and how to raise it."""

import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.bridges.executor.messages import State
from seoro.executor.limits import Limits, Policy
from seoro.executor.process.environment import for_runs, passed
from seoro.executor.runs.usage import TO_END, TraceFile, Usage, cut, size_of_files
from seoro.executor.sandbox import bubblewrap
from seoro.executor.service import ExecutorOptions, open_executor
from tests.executors import HELLO

DEADLINE = 60.0  # [s]
ENDLESS = """import osc.helpers
scenario endless:
    do serial:
        serial:
            log("{text}")
            wait elapsed(1ms)
        with:
            repeat()
""".replace("{text}", "x" * 280)
MINE = """from pathlib import Path
import os
import subprocess
import threading
import time
from seoro import ActionContext, action

@action("act")
async def act(ctx: ActionContext) -> None:
    folder = ctx.reserve_output("some", "something").parent
    {code}
    while True:
        await ctx.sleep(0.05)
"""
ACTING = "import osc.helpers\nimport osc.mine\nscenario main:\n    do serial:\n        act()\n"


def options(folder: Path, **limits: object) -> ExecutorOptions:
    policy = Policy(everybody=Limits.model_validate(limits))
    return ExecutorOptions("lab-a", folder / "state", listen=f"unixsock-stream/{folder}/hub", policy=policy)


def acting(folder: Path, code: str) -> Path:
    """Write a scenario whose action executes some code, and then waits endlessly."""
    library = folder / "seoro.libraries"
    library.mkdir()
    (library / "mine.osc").write_text("action act\n")
    (library / "mine.py").write_text(MINE.replace("{code}", code))
    file = folder / "acting.osc"
    file.write_text(ACTING)
    return file


async def reason_of(
    made: ExecutorOptions, file: Path, **options: object
) -> tuple[State, str, list[dict[str, object]]]:
    async with open_executor(made), seoro.Client(made.listen) as client:
        run = await client.submit("lab-a", file, **options)  # type: ignore[arg-type]
        with anyio.fail_after(DEADLINE):
            with suppress(seoro.BackendError):
                await run.result()
        return run.state, run.info.reason, [record async for record in run.records()]


@pytest.mark.more
async def test_a_trace_at_its_limit_ends_its_run_with_the_reason(tmp_path: Path) -> None:
    file = tmp_path / "endless.osc"
    file.write_text(ENDLESS)
    state, reason, records = await reason_of(options(tmp_path, trace=1), file, clock="virtual")
    assert state is State.ERROR
    assert "the trace of the run has 1 MiB" in reason
    assert "`trace`" in reason
    assert [record["seq"] for record in records] == list(range(len(records)))
    [trace] = (tmp_path / "state" / "runs").glob("*/trace.jsonl")
    assert trace.stat().st_size <= (1 << 20) + TO_END
    assert trace.read_bytes().endswith(b"\n")
    assert records[-1]["kind"] == "run.end"


@pytest.mark.parametrize(
    ("limits", "code"),
    [
        ({"output": 2, "log": 1}, 'for n in range(5): (folder / f"{n}").write_bytes(b"x" * (1 << 19))'),
        ({"log": 1}, 'print("line of a log\\n" * 100_000)'),
        ({"processes": 4}, '[subprocess.Popen(["sleep", "60"]) for _ in range(8)]'),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
async def test_resources_of_a_run_are_limited(tmp_path: Path, limits: dict[str, int], code: str) -> None:
    made = options(tmp_path, allow=["python"], **limits)
    state, reason, _ = await reason_of(made, acting(tmp_path, code))
    assert state is State.ERROR
    assert "limit reached" in reason
    assert f"`{next(iter(limits))}`" in reason
    [log] = [*(tmp_path / "state" / "runs").glob("*/output/log.txt")] or [Path("/dev/null")]
    assert log.stat().st_size <= 1 << 20


async def test_an_allocation_beyond_the_memory_limit_fails_at_once(tmp_path: Path) -> None:
    code = "bytes(3 << 30) and None; return"  # at once, which the kernel refuses
    made = options(tmp_path, allow=["python"], memory=1024)
    state, reason, _ = await reason_of(made, acting(tmp_path, code))
    assert state is State.ERROR
    assert "MemoryError" in reason


@pytest.mark.skipif(os.geteuid() == 0, reason="the kernel does not limit tasks of root")
@pytest.mark.skipif(bool(bubblewrap.trouble()), reason="needs a sandbox")
async def test_the_number_of_threads_of_a_sandboxed_run_is_limited(tmp_path: Path) -> None:
    code = "[threading.Thread(target=time.sleep, args=(60,), daemon=True).start() for _ in range(500)]"
    made = options(tmp_path, allow=["python"], processes=8)
    state, reason, _ = await reason_of(made, acting(tmp_path, code))
    assert state is State.ERROR
    assert "can't start new thread" in reason


async def test_the_size_of_a_file_is_limited_by_the_output(tmp_path: Path) -> None:
    made = options(tmp_path, allow=["python"], output=1)
    state, reason, _ = await reason_of(made, acting(tmp_path, '(folder / "large").write_bytes(b"x" * (2 << 20))'))
    assert state is State.ERROR
    assert "File too large" in reason


async def test_runs_do_not_inherit_secret_variables(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("AWS_SECRET", "s3cret")
    monkeypatch.setenv("FLEET", "a")
    code = '(folder / "seen").write_text("".join(f"{n}={v}\\n" for n, v in os.environ.items())); return'
    made = options(tmp_path, allow=["python"], environment=["FLE*"])
    state, _, _ = await reason_of(made, acting(tmp_path, code))
    assert state is State.PASSED
    [seen] = (tmp_path / "state" / "runs").glob("*/output/seen")
    names = dict(line.partition("=")[::2] for line in seen.read_text().splitlines())
    assert "AWS_SECRET" not in names
    assert names["FLEET"] == "a"
    assert names["PATH"] == os.environ["PATH"]
    assert names["HOME"] != os.environ["HOME"]
    assert not Path(names["HOME"]).exists()  # it was removed with the end of the run


def test_only_named_variables_are_passed() -> None:
    around: Mapping[str, str] = {
        "PATH": "/bin",
        "LC_ALL": "C",
        "TOKEN": "x",
        "SEORO_KEYS": "keys",
        "HOME": "/root",
    }
    assert passed(around) == {"PATH": "/bin", "LC_ALL": "C"}
    assert passed(around, ["TOK*"]) == {"PATH": "/bin", "LC_ALL": "C", "TOKEN": "x"}
    assert Path(for_runs((), Path("keys"))["SEORO_KEYS"]).is_absolute()


async def test_an_executor_with_a_relative_folder_runs_scenarios(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    made = ExecutorOptions("lab-a", Path("state"), listen=f"unixsock-stream/{tmp_path}/hub")
    state, reason, _ = await reason_of(made, file)
    assert state is State.PASSED, reason


# ---------------------------------------------------------------- parts


def test_a_trace_ends_after_a_complete_line_at_its_limit(tmp_path: Path) -> None:
    line = b"x" * 1023 + b"\n"
    with (tmp_path / "trace").open("ab", buffering=0) as file:
        trace = TraceFile(file, limit=10 * 1024, reserve=0)
        assert trace.write(line * 10) == line * 10
        assert trace.is_full_with(line)
        assert trace.write(line * 1030) == line * 1024  # the room for its end
        assert trace.write(b"short\n") == b""
    assert (tmp_path / "trace").stat().st_size == 10 * 1024 + TO_END


def test_a_trace_leaves_the_reserve_of_the_disk_free(tmp_path: Path) -> None:
    with (tmp_path / "trace").open("ab", buffering=0) as file:
        trace = TraceFile(file, limit=1 << 30, reserve=1 << 60)
        assert trace.lacks_disk(b"line\n")
        assert trace.write(b"line\n") == b""
        assert not TraceFile(file, 1 << 30, 0).lacks_disk(b"line\n")


def test_a_file_is_truncated_after_a_complete_line(tmp_path: Path) -> None:
    file = tmp_path / "log"
    file.write_bytes(b"one\ntwo\nthree\n")
    cut(file, 20)
    assert file.read_bytes() == b"one\ntwo\nthree\n"
    cut(file, 9)
    assert file.read_bytes() == b"one\ntwo\n"
    cut(tmp_path / "none", 9)


def test_small_files_and_folders_count_with_their_disk_blocks(tmp_path: Path) -> None:
    for number in range(10):
        (tmp_path / f"{number}").mkdir()
        (tmp_path / f"{number}" / "empty").touch()
    assert size_of_files(tmp_path) == 20 * 4096


def test_a_run_within_its_limits_has_no_excess() -> None:
    limits = Limits(memory=100, processes=10, output=1, log=1)
    assert Usage(100, 10, 1 << 20, 1 << 20).excess(limits) is None
    excess = Usage(100, 10, 2 << 20, 0).excess(limits)
    assert excess is not None
    assert excess.is_to_kill  # it continues to write

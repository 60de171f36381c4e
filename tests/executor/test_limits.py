"""Limits: excessive requests are refused, and excessive runs ended, with a message."""

import json
import re
import sqlite3
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import anyio
import pytest

import seoro
from seoro.bridges.executor import messages as wire
from seoro.bridges.executor.messages import State
from seoro.client.runs import RemoteRun
from seoro.errors import BackendRefused, UsageError
from seoro.executor.limits import Limits, Policy, read_policy
from seoro.executor.runs.fair_queue import FairQueue
from seoro.executor.runs.memory import Census, used_by
from seoro.executor.service import ExecutorOptions, open_executor
from seoro.executor.storage.store import Store
from seoro.security.keys.folder import read_keys
from seoro.security.network.rate_limiter import MOST, RateLimiter
from seoro.security.signing.audit_log import AuditLog, check_log
from tests.executors import HELLO, LONG
from tests.labs import NAME, free_port, keyed_executor, make_lab

HUNGRY = """from seoro import ActionContext, action

@action("eat")
async def eat(ctx: ActionContext) -> None:
    food = b"x" * (400 << 20)
    while food:
        await ctx.sleep(0.1)
"""
EATING = "import osc.helpers\nimport osc.mine\nscenario main:\n    do serial:\n        eat()\n"
DEADLINE = 30.0  # [s]


def options(folder: Path, jobs: int = 1, **limits: object) -> ExecutorOptions:
    policy = Policy(everybody=Limits.model_validate(limits))
    return ExecutorOptions(
        "lab-a", folder / "state", listen=f"unixsock-stream/{folder}/hub", jobs=jobs, policy=policy
    )


@pytest.fixture
def long(tmp_path: Path) -> Path:
    file = tmp_path / "long.osc"
    file.write_text(LONG)
    return file


async def begun(run: RemoteRun) -> None:
    with anyio.fail_after(DEADLINE):
        async for record in run.records():
            if record["kind"] == "log":
                return


async def test_a_run_beyond_its_time_limit_is_stopped(tmp_path: Path, long: Path) -> None:
    made = options(tmp_path, time=0.5)
    async with open_executor(made), seoro.Client(made.listen) as client:
        run = await client.submit("lab-a", long)
        with anyio.fail_after(DEADLINE):
            verdict = await run.result()
    assert verdict.status is seoro.RunStatus.ERROR
    assert "longer than 0.5 s" in verdict.reason
    assert "`time`" in verdict.reason


async def test_a_run_beyond_its_memory_limit_is_killed(tmp_path: Path) -> None:
    folder = tmp_path / "seoro.libraries"
    folder.mkdir()
    (folder / "mine.osc").write_text("action eat\n")
    (folder / "mine.py").write_text(HUNGRY)
    file = tmp_path / "eating.osc"
    file.write_text(EATING)
    made = options(tmp_path, memory=300, allow=["python"])
    async with open_executor(made), seoro.Client(made.listen) as client:
        run = await client.submit("lab-a", file)
        with anyio.fail_after(DEADLINE), pytest.raises(seoro.BackendError, match="more than 300 MiB"):
            await run.result()
        assert run.state is State.ERROR
        other = tmp_path / "hello.osc"
        other.write_text(HELLO)
        assert (await (await client.submit("lab-a", other)).result()).passed


@pytest.mark.more
async def test_the_number_of_running_and_waiting_runs_of_a_user_is_limited(tmp_path: Path, long: Path) -> None:
    made = options(tmp_path, jobs=3, running=1, waiting=2)
    async with open_executor(made), seoro.Client(made.listen) as client:
        runs = [await client.submit("lab-a", long)]
        await begun(runs[0])
        runs += [await client.submit("lab-a", long) for _ in range(2)]
        with pytest.raises(BackendRefused, match="2 of your runs are already waiting"):
            await client.submit("lab-a", long)
        states = [(await client.run(run.id)).state for run in runs]
        assert states == [State.RUNNING, State.QUEUED, State.QUEUED]
        await runs[0].stop()
        await begun(runs[1])
        for run in runs:
            await run.stop()


async def test_a_too_large_bundle_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "hello.osc"
    file.write_text(f"import osc.mine\n{HELLO}")
    (tmp_path / "seoro.libraries").mkdir()
    (tmp_path / "seoro.libraries" / "mine.osc").write_text("action nothing\n")
    (tmp_path / "seoro.libraries" / "mine.py").write_text(f"# {'x' * (2 << 20)}\n")
    made = options(tmp_path, bundle=1)
    async with open_executor(made), seoro.Client(made.listen) as client:
        with pytest.raises(BackendRefused, match=r"have 2\.0 MiB; the limit of this executor is 1 MiB"):
            await client.submit("lab-a", file)


async def test_a_scenario_with_a_forbidden_endpoint_is_invalid(tmp_path: Path) -> None:
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    made = options(tmp_path, reach=["tcp/192.0.2.2:7447"])
    async with open_executor(made), seoro.Client(made.listen) as client:
        run = await client.submit("lab-a", file, ros=seoro.Ros("tcp/192.0.2.1:7447"))
        with pytest.raises(UsageError, match=r"does not allow scenarios to connect to tcp/192\.0\.2\.1:7447"):
            await run.result()
        assert run.state is State.INVALID


def test_limits_of_roles_override_the_common_ones(tmp_path: Path) -> None:
    file = tmp_path / "policy.yaml"
    file.write_text(
        "everybody:\n  allow: [python]\n  time: 60\nroles:\n  admin:\n    allow: [run_process]\n    commands: 7\n"
    )
    policy = read_policy(file).also(frozenset({"ros_run"}), frozenset({"tls/hub:7447"}))
    admin, other = policy.of("admin"), policy.of("operator")
    assert (admin.allowed, admin.time, admin.rate) == (("ros_run", "run_process"), 60.0, (7.0, 70.0))
    assert (other.allowed, other.time, other.running) == (("python", "ros_run"), 60.0, None)
    assert admin.reached == other.reached == ("tls/hub:7447",)
    assert policy.allowed == {"python", "run_process", "ros_run"}


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("roles:\n  boss: {time: 3}\n", "policy.yaml:2: unknown role 'boss'"),
        ("everybody:\n  time: -1\n", "policy.yaml:2: everybody.time: Input should be greater than 0"),
        ("everybody:\n  speed: 1\n", "policy.yaml:2: everybody.speed: unknown key `speed` (keys: "),
        ("everybody: {bundle: 5000}\n", "less than or equal to 1024"),
        ("a: [\n", "invalid YAML"),
    ],
)
def test_invalid_policies_are_reported_with_the_line(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "policy.yaml"
    file.write_text(text)
    with pytest.raises(UsageError, match=re.escape(message)):
        read_policy(file)


def test_the_command_rate_is_limited_for_each_caller() -> None:
    now = [0.0]
    rates = RateLimiter(lambda: now[0])
    assert [rates.acquire("a", 2.0, 3.0) for _ in range(4)] == [True, True, True, False]
    assert rates.acquire("b", 2.0, 3.0)
    now[0] = 0.5
    assert [rates.acquire("a", 2.0, 3.0) for _ in range(2)] == [True, False]
    for number in range(MOST):
        rates.acquire(str(number), 2.0, 3.0)
    assert rates.acquire("a", 2.0, 3.0)  # forgotten, as long as it has had time to fill


def test_the_next_run_is_one_within_the_limits() -> None:
    waiting = FairQueue()
    for run, who in (("a0", "a"), ("a1", "a"), ("b0", "b")):
        waiting.add(run, 0, who)
    assert waiting.first(lambda run: run.startswith("b")) == "b0"
    assert waiting.first(lambda run: False) is None
    assert waiting.take("b0") == "b0"
    assert list(waiting) == ["a0", "a1"]


def test_memory_of_all_descendants_of_a_process_is_counted() -> None:
    script = "import subprocess, sys; food = b'x' * (120 << 20); print('ready', flush=True); input()"
    outer = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {script!r}])"
    command = [sys.executable, "-c", outer]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline()
        assert used_by(Census().family(process.pid)) >= 120
        process.communicate(b"\n", 10)
    assert used_by(Census().family(process.pid)) == 0


@pytest.mark.more
async def test_a_user_beyond_the_command_rate_can_still_stop(tmp_path: Path) -> None:
    lab = make_lab(tmp_path / "lab")
    file = tmp_path / "long.osc"
    file.write_text(LONG)
    policy = tmp_path / "policy.yaml"
    policy.write_text("roles:\n  operator: {commands: 1}\n")
    with keyed_executor(tmp_path, lab, "--policy", str(policy)) as there:
        async with seoro.Client(there.endpoint, lab.keys("anna")) as anna:
            run = await anna.submit(NAME, file)
            run.executor.patience = 0.0
            with pytest.raises(
                seoro.BackendError, match=r"anna \(operator\) sends more than 1 requests per second"
            ):
                for _ in range(100):
                    await run.executor.ask(wire.LIST_RUNS, wire.ListRuns())
            await run.stop()
            async with seoro.Client(there.endpoint, lab.keys("vera")) as vera:
                assert [each.id for each in await vera.runs()] == [run.id]


async def test_commands_without_an_audit_entry_are_not_executed(tmp_path: Path) -> None:
    lab = make_lab(tmp_path / "lab")
    file = tmp_path / "long.osc"
    file.write_text(LONG)
    path = tmp_path / "state" / "audit.jsonl"
    endpoint = f"tls/127.0.0.1:{free_port()}"
    made = ExecutorOptions(NAME, tmp_path / "state", listen=endpoint, keys=lab.keys(NAME))
    async with open_executor(made), seoro.Client(endpoint, lab.keys("anna")) as anna:
        run = await anna.submit(NAME, file)
        written = path.read_bytes()

        def refuse(*arguments: object, **entry: object) -> None:
            raise OSError(28, "No space left on device")

        with pytest.MonkeyPatch.context() as broken:
            broken.setattr(AuditLog, "write", refuse)
            with pytest.raises(BackendRefused, match="cannot write into its audit log: No space left"):
                await anna.submit(NAME, file)
            await run.stop()
            assert path.read_bytes() == written
        assert len(await anna.runs()) == 1
        await run.result()
        with pytest.MonkeyPatch.context() as broken:
            broken.setattr(Store, "remove", refuse)
            with pytest.raises(BackendRefused, match="fault in the executor"):
                await run.remove()
        await run.remove()
    check_log(path, read_keys(lab.keys("anna")).authority)
    entries = [(line["what"], line.get("outcome")) for line in map(json.loads, path.read_bytes().splitlines())]
    assert {("stop_run", "done"), ("run", "cancelled"), ("remove_run", "broken off"), ("remove_run", "done")} < {
        *entries
    }


@pytest.mark.more
async def test_outcomes_of_runs_are_audited_after_the_executor_died(tmp_path: Path) -> None:
    lab = make_lab(tmp_path / "lab")
    file = tmp_path / "long.osc"
    file.write_text(LONG)
    endpoint = f"tls/127.0.0.1:{free_port()}"
    made = ExecutorOptions(NAME, tmp_path / "state", listen=endpoint, keys=lab.keys(NAME))
    async with open_executor(made), seoro.Client(endpoint, lab.keys("anna")) as anna:
        run = await anna.submit(NAME, file)
    database = sqlite3.connect(tmp_path / "state" / "runs.sqlite")
    with database:  # simulates a death during the run
        database.execute("UPDATE runs SET state = 'running', ended = NULL")
    database.close()
    async with open_executor(made):
        pass
    last = json.loads((tmp_path / "state" / "audit.jsonl").read_bytes().splitlines()[-1])
    assert (last["what"], last["run"], last["outcome"], last["by"]) == ("run", run.id, "lost", "anna")
    assert last["role"] == "operator"
    assert "the executor died" in last["reason"]


@pytest.mark.more
async def test_a_full_disk_refuses_submissions_and_runs_can_be_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    long, hello = tmp_path / "long.osc", tmp_path / "hello.osc"
    long.write_text(LONG)
    hello.write_text(HELLO)
    made = options(tmp_path, free=0)
    async with open_executor(made), seoro.Client(made.listen) as client:
        run = await client.submit("lab-a", long)
        usage = SimpleNamespace(total=1 << 40, free=-1)
        monkeypatch.setattr("seoro.executor.storage.blobs.shutil.disk_usage", lambda _folder: usage)
        for file in (hello, long):  # missing and present ones
            with pytest.raises(BackendRefused, match=r"its disk has .* left.*remove old runs by `seoro rm`"):
                await client.submit("lab-a", file)
        await run.stop()
        assert (await run.result()).status.value == "cancelled"


@pytest.mark.more
async def test_turns_are_by_the_names_in_certificates(tmp_path: Path) -> None:
    lab = make_lab(tmp_path / "lab")
    long = tmp_path / "long.osc"
    long.write_text(LONG)
    endpoint = f"tls/127.0.0.1:{free_port()}"
    made = ExecutorOptions(NAME, tmp_path / "state", listen=endpoint, keys=lab.keys(NAME))
    async with (  # of one user at one machine
        open_executor(made),
        seoro.Client(endpoint, lab.keys("anna")) as anna,
        seoro.Client(endpoint, lab.keys("ada")) as ada,
    ):
        first = await anna.submit(NAME, long)
        async for record in first.records():
            if record.get("message") == "begun":
                break
        runs = [await anna.submit(NAME, long), await anna.submit(NAME, long), await ada.submit(NAME, long)]
        places = {each.id: (each.info.by, each.info.place) for each in await anna.runs()}
        assert [places[run.id] for run in runs] == [("anna", 1), ("anna", 3), ("ada", 2)]
        for run in (*runs, first):
            await run.stop()

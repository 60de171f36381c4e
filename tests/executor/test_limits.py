"""Limits: what is too much is refused or ended, and said."""

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
from seoro.errors import BackendRefused, InvalidUse
from seoro.executor.limits import Limits, Policy, read_policy
from seoro.executor.memory import Census, used_by
from seoro.executor.order import Waiting
from seoro.executor.running import ExecutorOptions, executing
from seoro.executor.store import Store
from seoro.keys.audit import Audit, check_log
from seoro.keys.folder import read_keys
from seoro.rates import MOST, Rates
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


async def test_a_run_that_takes_too_long_is_stopped(tmp_path: Path, long: Path) -> None:
    made = options(tmp_path, time=0.5)
    async with executing(made), seoro.Client(made.listen) as client:
        run = await client.submit("lab-a", long)
        with anyio.fail_after(DEADLINE):
            verdict = await run.result()
    assert verdict.status is seoro.RunStatus.ERROR
    assert "longer than 0.5 s" in verdict.reason
    assert "`time`" in verdict.reason


async def test_a_run_that_takes_too_much_memory_is_killed(tmp_path: Path) -> None:
    folder = tmp_path / "seoro.libraries"
    folder.mkdir()
    (folder / "mine.osc").write_text("action eat\n")
    (folder / "mine.py").write_text(HUNGRY)
    file = tmp_path / "eating.osc"
    file.write_text(EATING)
    made = options(tmp_path, memory=300, allow=["python"])
    async with executing(made), seoro.Client(made.listen) as client:
        run = await client.submit("lab-a", file)
        with anyio.fail_after(DEADLINE), pytest.raises(seoro.BackendError, match="more than 300 MiB"):
            await run.result()
        assert run.state is State.ERROR
        other = tmp_path / "hello.osc"
        other.write_text(HELLO)
        assert (await (await client.submit("lab-a", other)).result()).passed


async def test_one_has_so_many_runs_that_go_on_and_wait(tmp_path: Path, long: Path) -> None:
    made = options(tmp_path, jobs=3, running=1, waiting=2)
    async with executing(made), seoro.Client(made.listen) as client:
        runs = [await client.submit("lab-a", long)]
        await begun(runs[0])
        runs += [await client.submit("lab-a", long) for _ in range(2)]
        with pytest.raises(BackendRefused, match="2 of your runs wait already"):
            await client.submit("lab-a", long)
        states = [(await client.run(run.id)).state for run in runs]
        assert states == [State.RUNNING, State.QUEUED, State.QUEUED]
        await runs[0].stop()
        await begun(runs[1])
        for run in runs:
            await run.stop()


async def test_a_scenario_with_too_many_files_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "hello.osc"
    file.write_text(f"import osc.mine\n{HELLO}")
    (tmp_path / "seoro.libraries").mkdir()
    (tmp_path / "seoro.libraries" / "mine.osc").write_text("action nothing\n")
    (tmp_path / "seoro.libraries" / "mine.py").write_text(f"# {'x' * (2 << 20)}\n")
    made = options(tmp_path, bundle=1)
    async with executing(made), seoro.Client(made.listen) as client:
        with pytest.raises(BackendRefused, match=r"2\.0 MiB of files, more than the 1 MiB"):
            await client.submit("lab-a", file)


async def test_a_scenario_that_wants_to_reach_another_machine_is_not_run(tmp_path: Path) -> None:
    file = tmp_path / "hello.osc"
    file.write_text(HELLO)
    made = options(tmp_path, reach=["tcp/192.0.2.2:7447"])
    async with executing(made), seoro.Client(made.listen) as client:
        run = await client.submit("lab-a", file, ros=seoro.Ros("tcp/192.0.2.1:7447"))
        with pytest.raises(InvalidUse, match=r"does not let scenarios reach tcp/192\.0\.2\.1:7447"):
            await run.result()
        assert run.state is State.INVALID


def test_roles_have_limits_over_those_of_everybody(tmp_path: Path) -> None:
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
        ("roles:\n  boss: {time: 3}\n", "policy.yaml:2: nobody submits as 'boss'"),
        ("everybody:\n  time: -1\n", "policy.yaml:2: everybody.time: Input should be greater than 0"),
        ("everybody:\n  speed: 1\n", "policy.yaml:2: everybody.speed: unknown key `speed` (keys: "),
        ("everybody: {bundle: 5000}\n", "less than or equal to 1024"),
        ("a: [\n", "no valid YAML"),
    ],
)
def test_what_is_wrong_with_a_policy_is_said_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    file = tmp_path / "policy.yaml"
    file.write_text(text)
    with pytest.raises(InvalidUse, match=re.escape(message)):
        read_policy(file)


def test_commands_are_counted_for_each_caller() -> None:
    now = [0.0]
    rates = Rates(lambda: now[0])
    assert [rates.take("a", 2.0, 3.0) for _ in range(4)] == [True, True, True, False]
    assert rates.take("b", 2.0, 3.0)
    now[0] = 0.5
    assert [rates.take("a", 2.0, 3.0) for _ in range(2)] == [True, False]
    for number in range(MOST):
        rates.take(str(number), 2.0, 3.0)
    assert rates.take("a", 2.0, 3.0)  # forgotten, as long as it has had time to fill


def test_the_next_run_is_one_that_may_go_on() -> None:
    waiting = Waiting()
    for run, who in (("a0", "a"), ("a1", "a"), ("b0", "b")):
        waiting.add(run, 0, who)
    assert waiting.first(lambda run: run.startswith("b")) == "b0"
    assert waiting.first(lambda run: False) is None
    assert waiting.take("b0") == "b0"
    assert list(waiting) == ["a0", "a1"]


def test_memory_of_all_below_a_process_is_counted() -> None:
    script = "import subprocess, sys; food = b'x' * (120 << 20); print('ready', flush=True); input()"
    outer = f"import subprocess, sys; subprocess.run([sys.executable, '-c', {script!r}])"
    command = [sys.executable, "-c", outer]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE) as process:
        assert process.stdout is not None
        assert process.stdout.readline()
        assert used_by(Census().family(process.pid)) >= 120
        process.communicate(b"\n", 10)
    assert used_by(Census().family(process.pid)) == 0


async def test_who_asks_too_often_has_to_wait_and_can_still_stop(tmp_path: Path) -> None:
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
                seoro.BackendError, match=r"anna \(operator\) asks for more than 1 things a second"
            ):
                for _ in range(100):
                    await run.executor.ask(wire.LIST_RUNS, wire.ListRuns())
            await run.stop()
            async with seoro.Client(there.endpoint, lab.keys("vera")) as vera:
                assert [each.id for each in await vera.runs()] == [run.id]


async def test_what_cannot_be_written_down_is_not_done(tmp_path: Path) -> None:
    lab = make_lab(tmp_path / "lab")
    file = tmp_path / "long.osc"
    file.write_text(LONG)
    path = tmp_path / "state" / "audit.jsonl"
    endpoint = f"tls/127.0.0.1:{free_port()}"
    made = ExecutorOptions(NAME, tmp_path / "state", listen=endpoint, keys=lab.keys(NAME))
    async with executing(made), seoro.Client(endpoint, lab.keys("anna")) as anna:
        run = await anna.submit(NAME, file)
        written = path.read_bytes()

        def refuse(*arguments: object, **entry: object) -> None:
            raise OSError(28, "No space left on device")

        with pytest.MonkeyPatch.context() as broken:
            broken.setattr(Audit, "write", refuse)
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
    said = [(line["what"], line.get("outcome")) for line in map(json.loads, path.read_bytes().splitlines())]
    assert {("stop_run", "done"), ("run", "cancelled"), ("remove_run", "broken off"), ("remove_run", "done")} < {
        *said
    }


async def test_what_has_become_of_runs_is_written_down_also_after_the_executor_died(tmp_path: Path) -> None:
    lab = make_lab(tmp_path / "lab")
    file = tmp_path / "long.osc"
    file.write_text(LONG)
    endpoint = f"tls/127.0.0.1:{free_port()}"
    made = ExecutorOptions(NAME, tmp_path / "state", listen=endpoint, keys=lab.keys(NAME))
    async with executing(made), seoro.Client(endpoint, lab.keys("anna")) as anna:
        run = await anna.submit(NAME, file)
    database = sqlite3.connect(tmp_path / "state" / "runs.sqlite")
    with database:  # as if it had died while the run went on
        database.execute("UPDATE runs SET state = 'running', ended = NULL")
    database.close()
    async with executing(made):
        pass
    last = json.loads((tmp_path / "state" / "audit.jsonl").read_bytes().splitlines()[-1])
    assert (last["what"], last["run"], last["outcome"], last["by"]) == ("run", run.id, "lost", "anna")
    assert last["role"] == "operator"
    assert "the executor died" in last["reason"]


async def test_nothing_is_taken_by_a_disk_that_is_too_full_and_runs_can_be_stopped(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    long, hello = tmp_path / "long.osc", tmp_path / "hello.osc"
    long.write_text(LONG)
    hello.write_text(HELLO)
    made = options(tmp_path, free=0)
    async with executing(made), seoro.Client(made.listen) as client:
        run = await client.submit("lab-a", long)
        usage = SimpleNamespace(total=1 << 40, free=-1)
        monkeypatch.setattr("seoro.executor.room.shutil.disk_usage", lambda _folder: usage)
        for file in (hello, long):  # what it has not, and what it has
            with pytest.raises(BackendRefused, match=r"its disk has .* left.*`seoro rm` forgets runs"):
                await client.submit("lab-a", file)
        await run.stop()
        assert (await run.result()).status.value == "cancelled"


async def test_turns_go_by_the_names_in_certificates(tmp_path: Path) -> None:
    lab = make_lab(tmp_path / "lab")
    long = tmp_path / "long.osc"
    long.write_text(LONG)
    endpoint = f"tls/127.0.0.1:{free_port()}"
    made = ExecutorOptions(NAME, tmp_path / "state", listen=endpoint, keys=lab.keys(NAME))
    async with (  # of one user at one machine
        executing(made),
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

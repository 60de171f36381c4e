"""Campaigns on executors, which are real ones."""

from __future__ import annotations

import hashlib
import json
import os
import signal
from collections.abc import Callable, Iterator
from contextlib import ExitStack
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.campaign import opening
from seoro.campaign.runs import OF_THE_MACHINE
from seoro.cli.main import main
from tests.campaign.generated import VARIED as TEXT
from tests.campaign.test_campaigns import rows_so_far, simulators_of, start, table, write_deadly
from tests.executors import HELLO, RunningExecutor, executor
from tests.integration.conftest import wait_until

RANDOM = ("--strategy", "random", "--clock", "virtual", "--seed", "5", "-o", "out")
Command = Callable[..., list[str]]


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[RunningExecutor]:
    with executor(tmp_path_factory.mktemp("lab"), "--jobs", "2", "--allow", "python") as running:
        yield running


@pytest.fixture
def command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, lab: RunningExecutor) -> Command:
    """The command line of a campaign on the executor, in an empty folder."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("SEORO_EXECUTOR", lab.endpoint)
    Path("main.osc").write_text(TEXT)
    return lambda *more: ["campaign", "run", "main.osc", *RANDOM, "--on", "lab-a", *more]


def digest_of_table(path: str) -> str:
    """Return a hash of the columns that do not depend on the machine."""
    rows = [{key: row[key] for key in row if key not in OF_THE_MACHINE} for row in table(path)]
    return hashlib.sha256(repr(rows).encode()).hexdigest()


async def runs_at(endpoint: str) -> list[str]:
    """Return the states of all runs of an executor."""
    async with seoro.Client(endpoint) as client:
        return [run.state.value for run in await client.runs()]


def test_rows_are_those_of_this_machine(command: Command, lab: RunningExecutor) -> None:
    assert main(command("--runs", "100")) == 1
    here = ["campaign", "run", "main.osc", *RANDOM, "--runs", "100", "-o", "here"]
    assert main(here) == 1
    assert digest_of_table("out/runs.csv") == digest_of_table("here/runs.csv")
    rows = table()
    assert len(rows) == 100 and all(row["worker"].startswith("lab-a-") and row["host"] for row in rows)
    failed = [row for row in rows if row["status"] == "failed"]
    assert failed and all((Path("out") / row["folder"] / "trace.jsonl").stat().st_size for row in failed)
    assert sorted(path.name for path in Path("out/kept").iterdir()) == [Path(row["folder"]).name for row in failed]
    assert [path.name for path in Path("out/runs").iterdir()] == ["on-lab-a.jsonl"], "a shard of its own"
    assert anyio.run(runs_at, lab.endpoint) == [], "nothing is left at the executor"


@pytest.mark.more
def test_executors_and_this_machine_share_the_runs(command: Command) -> None:
    assert main(command("--runs", "60", "--on", "local", "-j", "1", "--keep", "none")) == 1
    assert [int(row["run"]) for row in table()] == list(range(1, 61))
    assert {path.name.partition("-")[0] for path in Path("out/runs").iterdir()} == {"on", table()[0]["host"]}


def test_a_run_that_ends_its_process_costs_itself_only(command: Command) -> None:
    write_deadly()
    assert main(command("--strategy", "grid")) == 3
    assert [(row["number"], row["status"]) for row in table()] == [
        ("1", "passed"), ("2", "passed"), ("3", "error"), ("4", "passed")
    ]  # fmt: skip
    assert "killed by signal 6" in table()[2]["reason"] and table()[2]["attempt"] == "2"
    assert json.loads(Path("out/campaign.json").read_text())["isolation"] == "run"
    assert len({row["worker"] for row in table()}) == 4


@pytest.mark.more
@pytest.mark.parametrize(("isolation", "pythons"), [("run", 1), ("process", 3)])
def test_runs_have_pythons_of_their_own_on_request(command: Command, isolation: str, pythons: int) -> None:
    write_deadly()
    Path("seoro.libraries/deadly.py").write_text("""from seoro import ActionContext, action


@action("die")
async def die(ctx: ActionContext, number: int) -> None:
    raise RuntimeError(f"the hash is {hash('seoro')}")  # each Python draws a seed for it
""")
    main(command("--strategy", "grid", "--isolation", isolation, "--set", "number=1", "--repeat", "3"))
    reasons = [row["reason"] for row in table()]
    assert len(reasons) == 3 and all("the hash is" in reason for reason in reasons), reasons
    assert len(set(reasons)) == pythons


@pytest.mark.more
def test_ctrl_c_stops_runs_at_the_executor(command: Command, lab: RunningExecutor) -> None:
    process = start(*command("--runs", "100000", "--keep", "none")[1:])
    try:
        wait_until(lambda: rows_so_far() > 20, 60.0)
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 130
    finally:
        process.kill()
        process.wait()
    assert anyio.run(runs_at, lab.endpoint) == []
    assert len(table()) == rows_so_far()


@pytest.mark.parametrize(
    ("more", "message"),
    [
        (("--on", "lab-b"), "unknown executor 'lab-b'"),
        (("--sim", "mujuco", "--clock", "sim"), "has no simulator 'mujuco'"),
        (("--jobs", "2"), "`--jobs` is for runs on this machine"),
    ],
)
def test_executors_that_cannot_run_it_are_refused(
    command: Command, more: tuple[str, ...], message: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(command("--runs", "5", *more)) == 2
    assert message in capsys.readouterr().err
    assert not Path("out").exists(), "nothing has begun"


def test_a_scenario_that_the_executor_forbids_ends_the_campaign(
    command: Command, capsys: pytest.CaptureFixture[str]
) -> None:
    Path("main.osc").write_text("import osc.helpers\nscenario main:\n    do run_process('true')\n")
    assert main(command("--runs", "5")) == 2
    error = capsys.readouterr().err
    assert "the executor 'lab-a' cannot run the scenario" in error and "--allow run_process" in error
    assert not Path("out").exists()


def test_other_versions_of_seoro_are_refused(
    command: Command, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr(opening, "__version__", "0.0.1")
    assert main(command("--runs", "5")) == 2
    assert f"has seoro {seoro.__version__}, the campaign 0.0.1" in capsys.readouterr().err


def test_a_refused_submission_ends_the_campaign_at_its_beginning(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    Path("policy.yaml").write_text("everybody: {free: 1000000000}\n")
    with executor(tmp_path, "--jobs", "2", "--policy", "policy.yaml") as running:
        monkeypatch.setenv("SEORO_EXECUTOR", running.endpoint)
        assert main(["campaign", "run", "main.osc", *RANDOM, "--runs", "5", "--on", "lab-a"]) == 3
    error = capsys.readouterr().err
    assert "the executor 'lab-a' accepts no runs of the campaign" in error
    assert "the executor cannot store" in error and "MiB stay free" in error
    assert not Path("out").exists(), "nothing has begun"


@pytest.mark.more
def test_two_executors_share_the_runs_and_one_may_die(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    (tmp_path / "b").mkdir()
    with executor(tmp_path, "--jobs", "1") as first:
        monkeypatch.setenv("SEORO_EXECUTOR", first.endpoint)
        with executor(tmp_path / "b", "--jobs", "1", name="lab-b", connect=first.endpoint) as second:
            there = ("--runs", "600", "--on", "lab-a", "--on", "lab-b", "--keep", "none")
            process = start("run", "main.osc", *RANDOM, *there)
            try:
                wait_until(lambda: min(rows_so_far("on-lab-a*"), rows_so_far("on-lab-b*")) > 20, 60.0)
                second.kill()
                assert process.wait(120) == 1
            finally:
                process.kill()
                process.wait()
    rows = table()
    assert [int(row["run"]) for row in rows] == list(range(1, 601))
    assert {row["status"] for row in rows} == {"passed", "failed"}, "no run is an error"
    assert {row["worker"][:6] for row in rows} == {"lab-a-", "lab-b-"}


@pytest.mark.more
def test_no_row_is_lost_when_the_executor_dies(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    with ExitStack() as executors:
        running = executors.enter_context(executor(tmp_path, "--jobs", "2"))
        monkeypatch.setenv("SEORO_EXECUTOR", running.endpoint)
        process = start("run", "main.osc", *RANDOM, "--runs", "600", "--on", "lab-a", "--keep", "none")
        try:
            for ended in (50, 200):
                wait_until(lambda ended=ended: rows_so_far() > ended, 60.0)  # type: ignore[misc]
                running.kill()
                running = executors.enter_context(executor(tmp_path, "--jobs", "2"))
            assert process.wait(120) == 1
        finally:
            process.kill()
            process.wait()
    rows = table()
    assert [int(row["run"]) for row in rows] == list(range(1, 601))
    assert {row["status"] for row in rows} == {"passed", "failed"}, "no run is an error"


@pytest.mark.more
def test_campaigns_give_way_to_waiting_runs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    Path("hello.osc").write_text(HELLO)
    before = "import seoro.executor.runs.shifts as shifts\nshifts.SHIFT = shifts.PERIOD = 0.2"
    with executor(tmp_path, "--jobs", "1", before=before) as running:
        monkeypatch.setenv("SEORO_EXECUTOR", running.endpoint)
        process = start("run", "main.osc", *RANDOM, "--runs", "1000000", "--on", "lab-a", "--keep", "none")
        try:
            wait_until(lambda: rows_so_far() > 20, 60.0)
            assert main(["exec", "hello.osc", "--on", "lab-a"]) == 0
            ended = rows_so_far()
            wait_until(lambda: rows_so_far() > ended + 20, 60.0)
            process.send_signal(signal.SIGINT)
            assert process.wait(60) == 130
        finally:
            process.kill()
            process.wait()
    assert len({row["worker"] for row in table()}) > 1


@pytest.mark.more
def test_runs_of_a_killed_simulator_are_made_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text("""import osc.driving
scenario main:
    turtlebot4: differential_drive_robot
    do turtlebot4.drive(linear: 0.1mps, duration: 2s)
""")
    with executor(tmp_path, "--jobs", "1") as running:
        monkeypatch.setenv("SEORO_EXECUTOR", running.endpoint)
        there = ("--sim", "mujoco", "--rate", "4", "--repeat", "4", "--on", "lab-a", "-o", "out")
        process = start("run", "main.osc", *there)
        try:
            wait_until(lambda: rows_so_far() > 0, 60.0)
            (simulator,) = simulators_of(running.process.pid)
            os.kill(simulator, signal.SIGKILL)
            assert process.wait(60) == 0
        finally:
            process.kill()
            process.wait()
    assert [row["attempt"] for row in table()].count("2") == 1

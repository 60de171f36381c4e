"""Campaigns in real processes, on the command line."""

import csv
import fcntl
import json
import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as Xml

import pytest

from seoro.campaign.pool.simulators import simulator_node
from seoro.campaign.runs import OF_THE_MACHINE
from seoro.campaign.store.folder import shards_of
from seoro.cli.main import main
from seoro.errors import BackendError
from tests.integration.conftest import wait_until

Write = Callable[..., str]

TEXT = """import osc.types
import osc.helpers

scenario main:
    noise: float with:
        keep(it in [0.0, 0.2])
    way: length
    keep(way in [1m, 2m])
    keep(noise == 0.0 or way == 1m)
    shift: float
    keep(shift in [0.0..1.0])
    record(shift)
    do serial:
        wait elapsed({pause})
        compare(noise, "<", 0.1)
"""
VIRTUAL = ("--clock", "virtual", "--seed", "5", "-o", "out", "-j", "1")

DEADLY = """import osc.helpers
import osc.deadly
scenario main:
    number: int
    keep(number in [1, 2, 3, 4])
    do die(number)
"""


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    monkeypatch.chdir(tmp_path)

    def write_file(pause: str = "1h") -> str:
        (tmp_path / "main.osc").write_text(TEXT.format(pause=pause))
        return "main.osc"

    return write_file


def table(path: str = "out/runs.csv") -> list[dict[str, str]]:
    """The lines of a table of results."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_each_possible_combination_is_run_once(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", "run", write(), *VIRTUAL]) == 1
    out = capsys.readouterr().out
    assert "3 runs: 2 passed, 1 failed, 1 excluded by constraints" in out
    rows = table()
    shown = [(row["noise"], row["way"], row["seed"], row["status"], row["duration"]) for row in rows]
    assert shown == [
        ("0.0", "1.0", "5", "passed", "3600.0"),
        ("0.0", "2.0", "5", "passed", "3600.0"),
        ("0.2", "1.0", "5", "failed", "3600.0"),
    ]
    assert rows[2]["reason"] == "`compare` failed: `0.2 < 0.1` is false"
    assert rows[2]["reason_key"] == "`compare` failed: `# < #` is false"
    assert rows[2]["where"].startswith("main.osc:15")
    assert all(0.0 <= float(row["record.shift"]) <= 1.0 for row in rows[:2])
    assert len({row["trace_sha"] for row in rows}) == 3
    assert [bool(row["folder"]) for row in rows] == [False, False, True], "only what did not pass is kept"
    assert (Path("out") / rows[2]["folder"] / "trace.jsonl").is_file()
    assert sorted(path.name for path in Path("out/kept").iterdir()) == [Path(rows[2]["folder"]).name]
    assert "Failed: main" in Path("out", rows[2]["folder"], "report.html").read_text()
    cases = Xml.parse("out/test.xml").getroot().findall(".//testcase")
    assert [case.find("failure") is not None for case in cases] == [False, False, True]
    properties = {each.get("name"): each.get("value") for each in cases[2].iter("property")}
    assert properties["parameter.noise"] == "0.2"


def test_requirements_are_in_all_results(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    file = Path(write("0s"))
    file.write_text("# seoro: requirement REQ-12, REQ-<13>\n" + file.read_text())
    assert main(["campaign", "run", str(file), *VIRTUAL]) == 1
    cases = Xml.parse("out/test.xml").getroot().findall(".//testcase")
    named = [
        [each.get("value") for each in case.iter("property") if each.get("name") == "requirement"]
        for case in cases
    ]
    assert named == [["REQ-12", "REQ-<13>"]] * 3
    assert "<dd>REQ-12, REQ-&lt;13&gt;</dd>" in Path("out/report.html").read_text()
    capsys.readouterr()
    assert main(["campaign", "status", "out"]) == 0
    assert "  requirements: REQ-12, REQ-<13>\n" in capsys.readouterr().out
    main(["campaign", "status", "--json", "out"])
    assert json.loads(capsys.readouterr().out)["requirements"] == ["REQ-12", "REQ-<13>"]


@pytest.mark.more
def test_the_same_runs_result_from_other_workers(write: Write) -> None:
    tables = []
    for jobs in ("1", "2"):
        command = ["campaign", "run", write("0s"), "--strategy", "random", "--runs", "12", "--overwrite", *VIRTUAL]
        main([*command, "-j", jobs])
        tables.append([{key: row[key] for key in row if key not in OF_THE_MACHINE} for row in table()])
    assert len(tables[0]) == 12 and len({row["id"] for row in tables[0]}) == 12
    assert tables[0] == tables[1]
    assert len({row["shift"] for row in tables[0]}) == 12, "ranges vary"


def test_points_are_repeated_with_other_seeds(write: Write) -> None:
    assert main(["campaign", "run", write("0s"), "--repeat", "2", "--set", "noise=0.0", *VIRTUAL]) == 0
    assert [(row["way"], row["variant"], row["seed"]) for row in table()] == [
        ("1.0", "1", "5"), ("1.0", "1", "6"), ("2.0", "2", "5"), ("2.0", "2", "6")
    ]  # fmt: skip
    fixed = ["--set", "noise=0.0", "--set", "way=1m", "--set", "shift=0.5", "--repeat", "3", "--overwrite"]
    assert main(["campaign", "run", "main.osc", *fixed, *VIRTUAL]) == 0, "nothing varies"
    assert [row["seed"] for row in table()] == ["5", "6", "7"]


def test_a_campaign_is_extended(write: Write) -> None:
    command = ["campaign", "run", write("0s"), "--strategy", "random", "--set", "noise=0.0", *VIRTUAL]
    assert main([*command, "--runs", "3"]) == 0
    before = table()
    assert main(["campaign", "resume", "out", "--runs", "5", "-j", "1"]) == 0
    assert len(table()) == 5 and table()[:3] == before


def test_a_campaign_on_one_robot_is_continued_without_simultaneous_runs(
    write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    main(["campaign", "run", write("0s"), *VIRTUAL])
    file = Path("out/campaign.json")
    asked = json.loads(file.read_text())
    asked["manifest"]["options"] |= {"ros": {"endpoint": "tcp/127.0.0.1:1"}, "clock": None}
    file.write_text(json.dumps(asked))
    assert main(["campaign", "resume", "out", "-j", "2"]) == 2
    assert "runs on one robot are sequential" in capsys.readouterr().err


def test_another_campaign_is_replaced_on_request_only(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    command = ["campaign", "run", write("0s"), "--set", "noise=0.0", *VIRTUAL]
    assert main(command) == 0
    assert main(command) == 2
    assert "contains another campaign" in capsys.readouterr().err
    stale = Path("out/kept/stale")
    stale.mkdir()
    assert main([*command, "--overwrite", "--clock", "sim"]) == 2
    assert stale.exists(), "invalid options remove nothing"
    assert main([*command, "--overwrite"]) == 0
    assert not stale.exists() and len(table()) == 2


def test_a_changed_scenario_is_not_continued(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    main(["campaign", "run", write("0s"), *VIRTUAL])
    write("1s")
    assert main(["campaign", "resume", "out"]) == 2
    assert "main.osc changed since it began" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--set", "noise=0.0", "--set", "way=1m", "--set", "shift=0.5"], "no parameter varies in `main`"),
        (["--set", "noise=0.0", "--set", "way=1m"], "of which the strategy `grid` has no values"),
        (["--strategy", "gird"], "did you mean `grid`"),
        (["--world", "maze"], "`--world` needs a simulator"),
        (["--connect", "tcp/127.0.0.1:1", "-j", "2"], "are sequential"),
        (["--scenario", "other"], "other"),
        (["-o", "main.osc"], "main.osc"),
    ],
)
def test_invalid_campaigns_are_rejected(
    arguments: list[str], message: str, write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["campaign", "run", write(), "-o", "out", *arguments]) == 2
    assert message in capsys.readouterr().err


def test_a_folder_without_a_campaign_is_refused(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    write()
    assert main(["campaign", "status", "."]) == 2
    assert "is not the folder of a campaign" in capsys.readouterr().err


def test_the_status_of_a_running_campaign_has_its_pace(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The interval of a complete one is that of a fixed number of runs."""
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(
        "import osc.helpers\nscenario main:\n    x: float\n    keep(x in [0.0..1.0])\n    do wait elapsed(1s)\n"
    )
    assert main(["campaign", "run", "main.osc", *VIRTUAL, "--strategy", "random", "--runs", "6"]) == 0
    capsys.readouterr()
    assert main(["campaign", "status", "out"]) == 0
    complete = capsys.readouterr().out
    assert "6 of 6 runs: 6 passed" in complete and "%" in complete
    assert "valid at any time" not in complete and "left" not in complete
    assert main(["campaign", "status", "out", "--json"]) == 0
    assert json.loads(capsys.readouterr().out) == {
        "scenario": "main.osc", "requirements": [], "runs": 6, "planned": 6, "ends": {"passed": 6},
        "is_running": False, "is_complete": True, "stopped": None,
    }  # fmt: skip
    [shard] = shards_of(Path("out"))
    shard.write_text("".join(shard.read_text().splitlines(keepends=True)[:-1]))
    with Path("out/lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        assert main(["campaign", "status", "out"]) == 0
    running = capsys.readouterr().out
    assert "5 of 6 runs: 5 passed" in running and "valid at any time" in running
    assert re.search(r", [\d.,]+/(s|min), \d+ (s|min) left", running)


@pytest.fixture
def deadly(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A scenario of four runs, whose third ends its process."""
    monkeypatch.chdir(tmp_path)
    write_deadly()


def write_deadly() -> None:
    """Write this scenario, with its library, into the working directory."""
    folder = Path("seoro.libraries")
    folder.mkdir()
    (folder / "deadly.osc").write_text("action die:\n    number: int\n")
    (folder / "deadly.py").write_text("""import os

from seoro import ActionContext, action


@action("die")
async def die(ctx: ActionContext, number: int) -> None:
    if number == 3:
        os.abort()
""")
    Path("main.osc").write_text(DEADLY)


@pytest.mark.parametrize("isolation", ["worker", "run", pytest.param("process", marks=pytest.mark.more)])
def test_a_run_that_ends_its_process_costs_itself_only(deadly: None, isolation: str) -> None:
    assert main(["campaign", "run", "main.osc", "--isolation", isolation, *VIRTUAL]) == 3
    assert [(row["number"], row["status"]) for row in table()] == [
        ("1", "passed"), ("2", "passed"), ("3", "error"), ("4", "passed")
    ]  # fmt: skip
    assert table()[2]["reason"] == "the run ended its process by SIGABRT" and table()[2]["attempt"] == "2"


def test_runs_with_python_of_their_own_share_no_process(deadly: None) -> None:
    main(["campaign", "run", "main.osc", "--set", "number=1", "--repeat", "2", *VIRTUAL])
    assert json.loads(Path("out/campaign.json").read_text())["isolation"] == "run"
    assert len({row["worker"] for row in table()}) == 2


def test_a_campaign_that_cannot_begin_leaves_no_folder(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["campaign", "run", write(), "--sim", "mujuco", "-o", "out"]) == 2
    assert "unknown simulator 'mujuco'" in capsys.readouterr().err
    assert not Path("out").exists()


async def test_a_simulator_that_does_not_start_shows_its_reason(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    program = tmp_path / "python"
    program.write_text("#!/bin/sh\necho 'no display' >&2\nexit 3\n")
    program.chmod(0o755)
    monkeypatch.setattr(sys, "executable", str(program))
    with pytest.raises(BackendError, match="did not start: it ended with status 3: no display"):
        async with simulator_node("mujoco"):
            pass


def start(*arguments: str, **more: Any) -> subprocess.Popen[bytes]:
    """Start a campaign."""
    command = [sys.executable, "-m", "seoro", "campaign", *arguments]
    return subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, **more)


def processes_of(word: str) -> list[str]:
    """Return the processes with a word in their command line, such as a folder."""
    found = []
    for entry in Path("/proc").iterdir():
        with suppress(OSError):
            if entry.name.isdecimal() and word.encode() in (entry / "cmdline").read_bytes().split(b"\0"):
                found.append(entry.name)
    return found


def rows_so_far(worker: str = "*") -> int:
    """Return the number of rows in all shards, or in those of a worker."""
    return sum(path.read_bytes().count(b"\n") for path in Path("out/runs").glob(f"{worker}.jsonl"))


def simulators_of(process: int) -> list[int]:
    """Return the simulators that a process or a descendant of it has started."""
    return [int(found) for found in processes_of("sim_nodes") if process in parents_of(found)]


def parents_of(process: str) -> Iterator[int]:
    """Yield the parent of a process, the parent of that, and so on."""
    while process != "0":
        process = Path(f"/proc/{process}/stat").read_text().rpartition(")")[2].split()[1]
        yield int(process)


@pytest.mark.parametrize("number", [signal.SIGKILL, signal.SIGINT])
def test_nothing_is_lost_when_the_campaign_is_ended(write: Write, number: signal.Signals) -> None:
    write("0s")
    folder = str(Path("out").absolute())
    there = ["--strategy", "random", "--runs", "100", "--set", "noise=0.0", *VIRTUAL, "-o", folder]
    process = start("run", "main.osc", *there)
    try:
        wait_until(lambda: rows_so_far() > 20, 60.0)
        assert processes_of(folder)
        process.send_signal(number)
        assert process.wait(60) == (130 if number == signal.SIGINT else -signal.SIGKILL)
        wait_until(lambda: not processes_of(folder), 20.0)
    finally:
        process.kill()
        process.wait()
    ended = rows_so_far()
    assert main(["campaign", "resume", "out", "-j", "2"]) == 0
    assert [int(row["run"]) for row in table()] == list(range(1, 101))
    assert ended <= rows_so_far() <= 100 + 1, "at most the open run was made again"


def test_the_memory_of_the_machine_is_not_needed_for_a_large_plan(write: Write) -> None:
    text = "".join(f"    p{number}: int\n    keep(p{number} in [0..9])\n" for number in range(6))
    write()
    Path("main.osc").write_text(f"import osc.helpers\nscenario main:\n{text}    do log('x')\n")
    process = start("run", "main.osc", "--levels", "10", *VIRTUAL)
    try:
        wait_until(lambda: rows_so_far() > 0, 60.0)
        assert Path("out/asked.jsonl").read_bytes().count(b"\n") < 1000, "of a million"
    finally:
        process.send_signal(signal.SIGINT)
        assert process.wait(60) == 130
    assert not [path for path in Path("out/kept").iterdir() if path.name.startswith(".")]


def test_runs_share_a_simulator_and_repeat_to_the_bit(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text("""import osc.driving
scenario main:
    turtlebot4: differential_drive_robot
    pace: speed
    keep(pace in [0.1mps, 0.2mps])
    do turtlebot4.drive(linear: pace, duration: 0.4s)
""")
    command = ["campaign", "run", "main.osc", "--sim", "mujoco", "--rate", "max", "--seed", "3", "-j", "1"]
    assert main([*command, "--repeat", "2", "-o", "out"]) == 0
    assert main([*command, "--repeat", "2", "-o", "again"]) == 0
    first, second = table(), table("again/runs.csv")
    assert len({row["trace_sha"] for row in first}) == 4
    assert [row["trace_sha"] for row in first] == [row["trace_sha"] for row in second]
    assert [float(row["turtlebot4.path_length"]) > 0.01 for row in first] == [True] * 4
    assert all(float(row["sim_cpu"]) > 0.0 for row in first)
    assert "real time" not in capsys.readouterr().err
    assert main(["campaign", "run", "main.osc", "--sim", "mujoco", "-o", "real"]) == 0
    assert "note: simulators keep to real time: `--rate max` runs them" in capsys.readouterr().err


@pytest.mark.more
def test_runs_of_a_simulator_that_is_killed_are_made_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text("""import osc.driving
scenario main:
    turtlebot4: differential_drive_robot
    do turtlebot4.drive(linear: 0.1mps, duration: 2s)
""")
    process = start("run", "main.osc", "--sim", "mujoco", "--repeat", "6", "-o", "out", "-j", "1", "--rate", "4")
    try:
        wait_until(lambda: rows_so_far() > 0, 60.0)
        (simulator,) = simulators_of(process.pid)
        os.kill(simulator, signal.SIGKILL)
        assert process.wait(60) == 0
    finally:
        process.kill()
        process.wait()
    rows = table()
    assert [row["status"] for row in rows] == 6 * ["passed"]
    assert [row["attempt"] for row in rows].count("2") == 1

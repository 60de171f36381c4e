"""`seoro sweep`: a run for each combination, and their results."""

import csv
import json
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree as Xml

import pytest

from seoro.cli.main import main
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
    do serial:
        wait elapsed({pause})
        compare(noise, "<", 0.1)
"""


@pytest.fixture
def write(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Write:
    monkeypatch.chdir(tmp_path)

    def write_file(pause: str = "1h") -> str:
        (tmp_path / "main.osc").write_text(TEXT.format(pause=pause))
        return "main.osc"

    return write_file


def table(path: str) -> list[dict[str, str]]:
    """The lines of a table of results."""
    with Path(path).open(newline="", encoding="utf-8") as file:
        return list(csv.DictReader(file))


def test_each_combination_that_is_possible_is_run(write: Write, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["sweep", write("1h"), "--clock", "virtual", "--seed", "5", "-o", "out"]) == 1
    out = capsys.readouterr().out
    assert "3 combinations of 2 parameters" in out
    assert "1 combination ruled out" in out
    assert "3 runs: " in out and "1 failed" in out
    rows = table("out/results.csv")
    shown = [(row["noise"], row["way"], row["seed"], row["status"], row["duration"]) for row in rows]
    assert shown == [
        ("0.0", "1.0", "5", "passed", "3600.0"),
        ("0.0", "2.0", "5", "passed", "3600.0"),
        ("0.2", "1.0", "5", "failed", "3600.0"),
    ]
    assert "`0.2 < 0.1` is false" in rows[2]["reason"]
    for row in rows:
        first, *_ = (Path("out") / row["folder"] / "trace.jsonl").read_text().splitlines()
        assert json.loads(first)["parameters"]["way"] == float(row["way"])
    cases = Xml.parse("out/test.xml").getroot().findall(".//testcase")
    assert [case.find("failure") is not None for case in cases] == [False, False, True]
    properties = {each.get("name"): each.get("value") for each in cases[2].iter("property")}
    assert properties["parameter.noise"] == "0.2"


def test_parameters_of_invocations_vary(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text("""import osc.types
import osc.helpers

scenario main:
    do serial:
        log() with:
            keep(it.msg in ["a", "b"])
        second: log() with:
            keep(it.msg in ["c", "d"])
""")
    assert main(["sweep", "main.osc", "-o", "out"]) == 0
    for row in table("out/results.csv"):
        records = map(json.loads, (Path("out") / row["folder"] / "trace.jsonl").read_text().splitlines())
        logs = [record["message"] for record in records if record["kind"] == "log"]
        assert logs == [row["log.msg"], row["second.msg"]]


def test_combinations_are_repeated_with_other_seeds(write: Write) -> None:
    command = ["sweep", write("0s"), "--seed", "7", "--repeat", "2", "--set", "noise=0.0", "-o", "out", "-j", "1"]
    assert main(command) == 0
    assert [(row["way"], row["seed"]) for row in table("out/results.csv")] == [
        ("1.0", "7"), ("1.0", "8"), ("2.0", "7"), ("2.0", "8")
    ]  # fmt: skip
    fixed = ["--set", "way=1m", "--overwrite"]
    assert main([*command, *fixed]) == 0, "nothing but the seed varies"
    assert [row["seed"] for row in table("out/results.csv")] == ["7", "8"]


def test_combinations_are_listed_and_written_without_a_run(
    write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    assert main(["sweep", write(), "--list"]) == 0
    assert capsys.readouterr().out.splitlines()[-3:] == [
        "1  noise=0.0 way=1m", "2  noise=0.0 way=2m", "3  noise=0.2 way=1m"
    ]  # fmt: skip
    assert main(["sweep", write(), "--emit", "variants"]) == 0
    assert sorted(path.name for path in Path("variants").iterdir()) == ["main_1.osc", "main_2.osc", "main_3.osc"]
    assert main(["exec", "variants/main_3.osc", "--dry-run"]) == 0
    assert "noise = 0.2" in capsys.readouterr().out
    assert not Path("sweep").exists()


def test_results_of_an_earlier_sweep_are_kept_without_overwrite(
    write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    command = ["sweep", write("0s"), "--set", "noise=0.0", "-o", "out"]
    assert main(command) == 0
    assert main(command) == 2
    assert "contains the results of another sweep" in capsys.readouterr().err
    (Path("out") / "runs" / "stale").mkdir()
    assert main([*command, "--overwrite", "--connect", "tcp/127.0.0.1:1", "--jobs", "2"]) == 2
    assert (Path("out") / "runs" / "stale").exists()
    assert main([*command, "--overwrite"]) == 0
    assert not (Path("out") / "runs" / "stale").exists()


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--set", "noise=0.0", "--set", "way=1m"], "no varied parameter in `main`"),
        (["--set", "shift=2.0"], "rule out all 4 combinations"),
        (["--world", "maze"], "`--world` needs a simulator"),
        (["--connect", "tcp/127.0.0.1:1", "-j", "2"], "are sequential"),
        (["--jobs", "0"], "expected a whole number from 1"),
        (["--scenario", "other"], "other"),
    ],
)
def test_invalid_sweeps_are_rejected(
    arguments: list[str], message: str, write: Write, capsys: pytest.CaptureFixture[str]
) -> None:
    try:
        status = main(["sweep", write(), *arguments])
    except SystemExit as refused:
        status = int(str(refused.code))
    assert status == 2
    assert message in capsys.readouterr().err


def test_a_run_without_a_verdict_is_an_error(write: Write) -> None:
    assert main(["sweep", write("0s"), "--sim", "nothing", "-o", "out"]) == 3
    assert {row["status"] for row in table("out/results.csv")} == {"error"}
    assert "nothing" in table("out/results.csv")[0]["reason"]


def runs_of(folder: Path) -> list[int]:
    """The processes that write into a folder."""
    found = []
    for entry in Path("/proc").iterdir():
        try:
            command = (entry / "cmdline").read_bytes() if entry.name.isdecimal() else b""
        except OSError:
            continue
        if b"exec" in command and f"-o={folder}".encode() in command:
            found.append(int(entry.name))
    return found


def test_ctrl_c_stops_the_runs_and_keeps_results(write: Write, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "seoro.cli.main", "sweep", write(), "-o", str(tmp_path), "-j", "2"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True) as process:
        traces = [tmp_path / "runs" / str(number) / "trace.jsonl" for number in (1, 2)]
        assert wait_until(lambda: all(path.exists() and path.stat().st_size > 500 for path in traces), 20)
        process.send_signal(signal.SIGINT)
        out, _ = process.communicate(timeout=20)
    assert process.returncode == 130
    assert "2 runs: 2 cancelled; 1 not started" in out
    assert [row["status"] for row in table(str(tmp_path / "results.csv"))] == ["cancelled"] * 2
    assert not runs_of(tmp_path)


def test_a_sweep_that_is_killed_leaves_no_runs(write: Write, tmp_path: Path) -> None:
    command = [sys.executable, "-m", "seoro.cli.main", "sweep", write(), "-o", str(tmp_path), "-j", "2"]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    assert wait_until(lambda: len(runs_of(tmp_path / "runs/1")) > 0, 20)
    os.kill(process.pid, signal.SIGKILL)
    process.wait()
    assert wait_until(lambda: not runs_of(tmp_path / "runs/1") and not runs_of(tmp_path / "runs/2"), 10)


def test_a_robot_that_is_wished_for_varies_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "lab.yaml").write_text("simulators:\n  sim: {simulator: mujoco}\n")
    actor = "scenario main:\n    robot: differential_drive_robot"
    text = "import osc.driving\n" + TEXT.format(pause="1h").replace("scenario main:", actor)
    file = tmp_path / "main.osc"
    file.write_text(text)
    lab = ["--lab", str(tmp_path / "lab.yaml"), "--set", "robot=any:cart", "--set", "shift=0.5"]
    assert main(["sweep", str(file), "--list", *lab]) == 0
    out = capsys.readouterr().out
    assert "3 combinations of 2 parameters" in out
    assert "1 combination ruled out" in out

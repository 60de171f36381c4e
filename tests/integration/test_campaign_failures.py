"""Failed runs of a campaign in a simulator: repeated, shrunk, and with their neighbours."""

import json
from pathlib import Path

import pytest

from seoro.campaign.store.folder import NEIGHBOURS, SHRINK
from seoro.cli.main import main
from tests.campaign.test_campaigns import table

TEXT = """import osc.types
import osc.driving
import osc.helpers

scenario main:
    turtlebot4: differential_drive_robot
    pace: speed
    keep(pace in [0.1mps..0.3mps])
    turn: angular_rate
    keep(turn in [0radps..0.4radps])
    do serial:
        turtlebot4.drive(linear: pace, angular: turn, duration: 1s)
        compare(pace, "<", 0.2mps)
"""


@pytest.mark.more
@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_failures_in_simulators_are_repeated_shrunk_and_surrounded(
    engine: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip(engine, reason=f"the engine {engine} is not installed")
    monkeypatch.chdir(tmp_path)
    Path("main.osc").write_text(TEXT)
    command = ["--sim", engine, "--rate", "max", "--seed", "4", "--strategy", "random", "--runs", "6", "-j", "1"]
    assert main(["campaign", "run", "main.osc", *command, "-o", "out"]) == 1
    failed = next(row for row in table("out/runs.csv") if row["status"] == "failed")
    run, pace = failed["run"], float(failed["pace"])

    capsys.readouterr()
    assert main(["campaign", "replay", "out", run]) == 0
    assert f"equal: the trace is that of run {run} to the bit" in capsys.readouterr().out

    assert main(["campaign", "shrink", "out", run, "-j", "1"]) == 0
    shrunk = json.loads(next(Path("out", SHRINK).rglob("shrunk.json")).read_text())
    assert shrunk["outcome"] == "minimal"
    assert float(shrunk["values"]["turn"].removesuffix("radps")) == 0.0
    assert 0.2 <= float(shrunk["values"]["pace"].removesuffix("mps")) <= pace

    assert main(["campaign", "neighbours", "out", run, "-j", "1"]) == 0
    assert Path("out", NEIGHBOURS).is_dir()
    lines = {line.split()[0]: line for line in capsys.readouterr().out.splitlines() if line.strip()}
    assert "yes" in lines["pace"] and "no" in lines["turn"].split()

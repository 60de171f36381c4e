"""`seoro bridge ros2 --robot` with keys, over `seoro router` with keys: commands as people type them."""

from __future__ import annotations

import json
from contextlib import ExitStack
from pathlib import Path

import pytest

from seoro.cli.main import main
from seoro.security.keys import VARIABLE
from seoro.security.keys.folder import read_keys
from seoro.security.keys.roles import Role
from seoro.security.signing.audit_log import check_log
from tests.bridges.ros2.robots.conftest import FAKE_ROBOT
from tests.labs import command, free_port, make_lab
from tests.routers import free_endpoint, process, router_process

DRIVE = """import osc.ros
import osc.driving
scenario main:
    tb: differential_drive_robot
    do serial:
        tb.drive(linear: 0.1mps, duration: 200ms)
"""


@pytest.mark.more
def test_a_bridge_with_keys_moves_its_robot_for_an_operator(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    lab = make_lab(tmp_path / "keys")
    lab.authority.add("hall", Role.NODE, lab.keys("hall"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    monkeypatch.setenv(VARIABLE, str(lab.keys("vera")))
    ros, endpoint = free_endpoint(), f"tls/127.0.0.1:{free_port()}"
    (tmp_path / "main.osc").write_text(DRIVE)
    file = tmp_path / "lab.yaml"
    file.write_text(f"bridges:\n  hall: {{connect: {endpoint}}}\nrobots:\n  tb: {{in: hall, as: tb}}\n")
    router = ("router", "--listen", endpoint, "--keys", str(lab.keys("hub")))
    bridge = ("bridge", "ros2", "--robot", "turtlebot4:tb@/tb", "--ros", ros, "--connect", endpoint)
    with ExitStack() as stack:
        stack.enter_context(router_process(ros))
        robot = (str(FAKE_ROBOT), str(tmp_path), ros, "tb", "geometry_msgs/msg/Twist")
        stack.enter_context(process(*robot))
        stack.enter_context(command(tmp_path / "router.log", endpoint, *router))
        keys = ("--keys", str(lab.keys("hall")))
        stack.enter_context(command(tmp_path / "bridge.log", endpoint, *bridge, *keys))
        run = ("exec", str(tmp_path / "main.osc"), "--lab", str(file))
        assert main(run) != 0
        assert "are those of vera (viewer); expected role: " in capsys.readouterr().err
        monkeypatch.setenv(VARIABLE, str(lab.keys("anna")))
        assert main(run) == 0, capsys.readouterr()
        assert main(["lab", "status", "--lab", str(file)]) == 0
        assert "tb of hall (bridge)" in capsys.readouterr().out
        assert main(["estop", "--lab", str(file)]) == 0
    noted = [line.split() for line in (tmp_path / "tb").read_text().splitlines()]
    assert 0.1 in [float(value) for _, kind, value in noted if kind == "velocity"]
    (log,) = (tmp_path / "state" / "seoro" / "bridges").glob("hall@*.audit.jsonl")
    assert check_log(log, read_keys(lab.keys("vera")).authority).writers == ("hall",)
    lines = [json.loads(line) for line in log.read_bytes().splitlines()]
    done = [(line["what"], line["by"]) for line in lines if line.get("outcome") == "done"]
    # A stop is published, and sent as a request; on a busy machine, by several connections.
    assert list(dict.fromkeys(done)) == [("take_robots", "anna"), ("emergency_stop", "anna")]
    assert done.count(("emergency_stop", "anna")) >= 2

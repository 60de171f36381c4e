"""Output of `seoro lab`, and its usage errors."""

from __future__ import annotations

import json
from collections.abc import Callable
from pathlib import Path

import anyio
import pytest

from seoro.cli.main import main
from seoro.client import Client
from seoro.client.lab import LabControl
from seoro.errors import BackendError, UsageError
from seoro.lab.reading import read_lab
from tests.bridges.robot.conftest import Rails
from tests.lab.test_runs import ALONE


@pytest.fixture
def lab(start_rails: Callable[..., Rails], tmp_path: Path) -> Path:
    rails = start_rails("--listen", f"unixsock-stream/{tmp_path}/rails", "line", "second")
    file = tmp_path / "lab.yaml"
    robots = "  cart1: {in: floor, as: line, type: cart}\n  cart2: {in: floor, as: second, type: cart}\n"
    file.write_text(f"bridges:\n  floor: {{connect: {rails.endpoint}}}\nrobots:\n{robots}")
    return file


def seoro(capsys: pytest.CaptureFixture[str], *arguments: str) -> tuple[int, str, str]:
    status = main(arguments)
    found = capsys.readouterr()
    return status, found.out, found.err


def test_lab_status_prints_a_table_of_robots(lab: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status, out, _ = seoro(capsys, "lab", "status", "--lab", str(lab))
    assert status == 0
    assert [line.split() for line in out.splitlines()] == [
        ["ROBOT", "TYPE", "AT", "STATE", "BATTERY", "LOCALISED", "SEEN"],
        ["cart1", "cart", "line", "of", "rails", "(bridge)", "free", "50%", "within", "0.00", "m", "now"],
        ["cart2", "cart", "second", "of", "rails", "(bridge)", "free", "50%", "within", "0.00", "m", "now"],
    ]


def test_a_lease_covers_all_robots_or_none_and_is_released_by_its_id(
    lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    at = ("--lab", str(lab))
    status, out, _ = seoro(capsys, "lab", "lease", "cart2", "--for", "2min", "--purpose", "new wheels", *at)
    assert status == 0
    name = out.partition("--lease ")[2].partition("`")[0]
    status, _, err = seoro(capsys, "lab", "lease", "cart1", "cart2", *at)
    assert status == 3
    assert "error: cannot lease cart1, cart2: the node 'rails': 'second' is leased until" in err
    _, out, _ = seoro(capsys, "lab", "status", "--json", *at)
    robots = json.loads(out)["nodes"][0]["robots"]
    assert [robot["lease"] and robot["lease"]["lease"] for robot in robots] == [None, name]
    assert seoro(capsys, "lab", "release", name, *at)[0] == 0
    status, _, err = seoro(capsys, "lab", "release", name, *at)
    assert status == 2
    assert f"unknown lease or leased robot '{name}'" in err


def test_requests_are_answered_for_programs(lab: Path, capsys: pytest.CaptureFixture[str]) -> None:
    at = ("--json", "--lab", str(lab))
    lease = json.loads(seoro(capsys, "lab", "lease", "cart2", *at)[1])
    assert lease["robots"] == ["cart2"]
    for arguments in (("release", lease["name"]), ("stop", "cart2")):
        status, out, _ = seoro(capsys, "lab", *arguments, *at)
        [outcome] = json.loads(out)["outcomes"]
        assert (status, outcome["error"], outcome["is_reached"], outcome["elapsed"]) == (0, "", True, None)
    status, out, _ = seoro(capsys, "estop", "train", *at)
    assert status == 3
    assert any("unknown robot" in each["error"] for each in json.loads(out)["outcomes"])


def test_an_emergency_stop_is_listed_and_released_with_a_reason(
    lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    at = ("--lab", str(lab))
    status, out, _ = seoro(capsys, "estop", "--reason", "smoke", *at)
    assert status == 0
    assert out.startswith("ok     the node 'rails': stopped line, second")
    status, out, _ = seoro(capsys, "lab", "status", *at)
    assert out.startswith("EMERGENCY STOP of rails by ")
    status, _, err = seoro(capsys, "lab", "release", "--all", *at)
    assert status == 2
    assert "missing reason" in err
    status, _, err = seoro(capsys, "lab", "release", "--all", "--reason", "toast", *at)  # without a terminal
    assert status == 2
    assert "confirm with `--yes`" in err
    assert seoro(capsys, "lab", "release", "--all", "--yes", "--reason", "toast", *at)[0] == 0
    assert "EMERGENCY" not in seoro(capsys, "lab", "status", *at)[1]


def test_an_emergency_stop_of_named_robots_reports_unknown_ones(
    lab: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    at = ("--lab", str(lab))
    status, out, _ = seoro(capsys, "estop", "second", "train", *at)
    assert status == 3
    assert "ok     the node 'rails': stopped second" in out
    assert "FAILED train: unknown robot (robots of the reached nodes: line, second)" in out
    assert "EMERGENCY STOP of second of rails by " in seoro(capsys, "lab", "status", *at)[1]
    assert seoro(capsys, "lab", "release", "--all", "--yes", "--reason", "toast", *at)[0] == 0


def test_unknown_robots_and_unreachable_endpoints_are_reported(
    lab: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    status, _, err = seoro(capsys, "lab", "stop", "train", "--lab", str(lab))
    assert status == 2
    assert "unknown robot 'train'" in err
    nowhere = f"unixsock-stream/{tmp_path}/nobody"
    status, out, _ = seoro(capsys, "lab", "status", "--connect", nowhere)
    assert status == 3
    assert f"cannot connect to {nowhere}" in out


@pytest.mark.parametrize(
    ("arguments", "words"),
    [
        (("release",), "expected robots, a lease or `--all`"),
        (("release", "cart1", "--all", "--reason", "x"), "`--all` cannot be combined with robots"),
    ],
)
def test_incomplete_lab_commands_are_refused(
    lab: Path, capsys: pytest.CaptureFixture[str], arguments: tuple[str, ...], words: str
) -> None:
    status, _, err = seoro(capsys, "lab", *arguments, "--lab", str(lab))
    assert status == 2
    assert words in err


def test_a_waiting_run_prints_the_holder_and_its_limit(
    lab: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    file = tmp_path / "go.osc"
    file.write_text(ALONE)
    assert seoro(capsys, "lab", "lease", "cart1", "cart2", "--lab", str(lab))[0] == 0
    command = ("exec", str(file), "--lab", str(lab), "--set", "leader=any:cart")
    status, _, err = seoro(capsys, *command)
    assert status == 3
    assert "cart1: leased" in err
    assert "cart2: leased" in err
    status, out, err = seoro(capsys, *command, "--wait", "0.5")
    assert status == 3
    assert "waiting: cannot acquire the robots of the bridge 'rails': 'line' is leased until" in out
    status, _, err = seoro(capsys, "exec", str(file), "--wait", "0.5")
    assert status == 2
    assert "add `--lab` or `--connect`" in err


async def test_a_program_leases_and_releases_robots_of_a_lab(start_rails: Callable[..., Rails], lab: Path) -> None:
    hub = start_rails("--listen", f"unixsock-stream/{lab.parent}/hub", "third").endpoint
    async with Client(hub) as client:
        there = client.lab(lab)
        async with there.leased("cart1", "cart2", purpose="new wheels") as lease:
            (member,) = await there.status()
            assert member.state is not None
            assert {robot.lease and robot.lease.lease for robot in member.state.robots} == {lease.name}
            with pytest.raises(
                BackendError, match="cannot lease cart2: the node 'rails': 'second' is leased until"
            ):
                await there.lease("cart2")
            with pytest.raises(UsageError, match="unknown robot 'third'"):
                await there.lease("third")
        assert [outcome.done for outcome in await there.stop("cart1")] == ["stopped"]
        assert (await there.stop_all("smoke"))[0].done == "stopped line, second"
        with pytest.raises(UsageError, match="missing reason"):
            await there.release_all(" ")
        assert [outcome.error for outcome in await there.release_all("toast")] == [""]
        with pytest.raises(UsageError, match="unknown lease"):
            await there.release(lease.name)
        assert [member.endpoint for member in await client.lab().status()] == [hub]


async def test_a_lease_ends_when_its_block_is_cancelled(lab: Path) -> None:
    there = LabControl(read_lab(lab).endpoints, read_lab(lab))
    with anyio.CancelScope() as scope:
        async with there.leased("cart1"):
            scope.cancel()
            await anyio.sleep(0.0)
    (member,) = await there.status()
    assert member.state is not None
    assert [robot.lease for robot in member.state.robots] == [None, None]

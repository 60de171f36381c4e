"""The tool that runs scenarios, over the stdio of a real server."""

from __future__ import annotations

import json
import signal
import subprocess
import sys
from pathlib import Path
from typing import Any

import anyio
import pytest

from tests.integration.conftest import wait_until
from tests.mcp.agents import PATIENCE, Agent, connected

TALKING = """import osc.helpers
import osc.talking

scenario talking:
    times: int = 1
    do serial:
        talk()
        log("done")
"""
LIBRARY = "action talk:\n    times: int = 1\n"
PYTHON = """from seoro import ActionContext, action

@action("talk")
async def talk(ctx: ActionContext, times: int) -> None:
    print("not a message of the protocol")
"""
WAITING = "import osc.types\nscenario waiting:\n    do serial:\n        wait elapsed(3600s)\n"


def _project(folder: Path) -> Path:
    libraries = folder / "seoro.libraries"
    libraries.mkdir()
    (libraries / "talking.osc").write_text(LIBRARY)
    (libraries / "talking.py").write_text(PYTHON)
    (folder / "main.osc").write_text(TALKING)
    (folder / "waiting.osc").write_text(WAITING)
    return folder


def _last(folder: Path) -> dict[str, Any]:
    [trace] = folder.glob("runs/*/trace.jsonl")
    found: dict[str, Any] = json.loads(trace.read_text().splitlines()[-1])
    return found


async def _until_running(agent: Agent) -> None:
    with anyio.fail_after(PATIENCE):
        while not any(each["status"] == "running" for each in (await agent.call("list_runs"))["runs"]):
            await anyio.lowlevel.checkpoint()


async def test_runs_leave_results_and_keep_the_protocol(tmp_path: Path) -> None:
    folder = _project(tmp_path)
    async with connected(folder, "--allow-run") as agent:
        tools = {tool.name: tool for tool in (await agent.client.list_tools()).tools}
        hints = tools["run_scenario"].annotations
        assert hints is not None
        assert (hints.read_only_hint, hints.destructive_hint) == (False, False)
        found = await agent.call("run_scenario", file="main.osc", parameters={"times": "4"}, seed=7)
        assert found["exit_status"] == 0
        assert found["result"]["status"] == "passed"
        assert (found["result"]["seed"], found["result"]["parameters"]["times"]) == (7, 4)
        assert found["result"]["logs"] == ["0.000 s done"]
        assert (folder / found["result"]["run"] / "test.xml").is_file()
        refused = await agent.error("run_scenario", file="main.osc", parameters={"no": "4"})
        assert "unknown parameter `no`" in refused
        assert len(list(folder.glob("runs/*"))) == 1
        (folder / "seoro.toml").write_text('lab = "hall.yaml"\n')
        assert "lab" in await agent.error("run_scenario", file="main.osc")


async def test_a_cancelled_request_ends_its_run(tmp_path: Path) -> None:
    folder = _project(tmp_path)
    async with connected(folder, "--allow-run") as agent:
        async with anyio.create_task_group() as group:
            group.start_soon(agent.client.call_tool, "run_scenario", {"file": "waiting.osc"})
            await _until_running(agent)
            group.cancel_scope.cancel()
        with anyio.fail_after(PATIENCE):
            while (await agent.call("list_runs"))["runs"][0]["status"] == "running":
                await anyio.lowlevel.checkpoint()
        assert _last(folder)["status"] == "cancelled"


async def test_runs_end_with_the_client(tmp_path: Path) -> None:
    folder = _project(tmp_path)
    with anyio.fail_after(PATIENCE):
        async with connected(folder, "--allow-run") as agent, anyio.create_task_group() as group:
            group.start_soon(agent.client.call_tool, "run_scenario", {"file": "waiting.osc"})
            await _until_running(agent)
            group.cancel_scope.cancel()
    with anyio.fail_after(PATIENCE):
        while _last(folder)["kind"] != "run.end":
            await anyio.lowlevel.checkpoint()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT, signal.SIGKILL])
def test_a_signal_ends_the_server_and_its_run(tmp_path: Path, number: signal.Signals) -> None:
    folder = _project(tmp_path)
    command = [sys.executable, "-m", "seoro", "mcp", "--allow-run", str(folder)]
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    assert process.stdin is not None
    assert process.stdout is not None
    client = {"protocolVersion": "2025-06-18", "capabilities": {}, "clientInfo": {"name": "test", "version": "1"}}
    call = {"name": "run_scenario", "arguments": {"file": "waiting.osc"}}
    _send(process, id=1, method="initialize", params=client)
    process.stdout.readline()
    _send(process, method="notifications/initialized")
    _send(process, id=2, method="tools/call", params=call)
    while not any(path.stat().st_size for path in folder.glob("runs/*/trace.jsonl")):
        _send(process, id=3, method="tools/call", params={"name": "list_runs", "arguments": {}})
        process.stdout.readline()
    process.send_signal(number)
    is_killed = number is signal.SIGKILL
    assert process.wait(PATIENCE) == (-number if is_killed else 128 + number)
    process.stdin.close()
    process.stdout.close()
    if is_killed:  # the run ends by itself
        wait_until(lambda: _last(folder)["kind"] == "run.end", PATIENCE)
    assert _last(folder)["status"] == "cancelled"


def _send(process: subprocess.Popen[str], **message: Any) -> None:
    assert process.stdin is not None
    process.stdin.write(json.dumps({"jsonrpc": "2.0", **message}) + "\n")
    process.stdin.flush()


async def test_results_stay_in_the_folder(tmp_path: Path) -> None:
    folder = tmp_path / "project"
    folder.mkdir()
    _project(folder)
    (tmp_path / "outside").mkdir()
    (folder / "runs").symlink_to(tmp_path / "outside")
    async with connected(folder, "--allow-run") as agent:
        assert "leads out" in await agent.error("run_scenario", file="main.osc")
        assert "outside" in await agent.error("run_scenario", file="../outside/x.osc")
    assert not list((tmp_path / "outside").iterdir())


@pytest.mark.more
@pytest.mark.engine("mujoco")
async def test_a_run_in_mujoco_has_measurements(tmp_path: Path) -> None:
    text = (
        "# seoro: simulators mujoco\nimport osc.ros\n\nscenario driving:\n    robot: differential_drive_robot\n"
        "    do serial:\n        robot.init_nav2(pose_3d(position_3d(x: 0.0m, y: 0.0m)))\n"
        "        robot.nav_to_pose(pose_3d(position_3d(x: 3.0m, y: -3.0m)))\n"
    )
    (tmp_path / "driving.osc").write_text(text)
    async with connected(tmp_path, "--allow-run") as agent:
        found = await agent.call("run_scenario", file="driving.osc", seed=1)
        assert found["result"]["status"] == "passed"
        assert found["result"]["measurements"]

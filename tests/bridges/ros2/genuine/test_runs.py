"""Runs that genuine nodes start and stop."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Any

import anyio
import pytest

from seoro.bridges.ros2.runs.node import DIAGNOSTICS
from seoro.bridges.ros2.state.stopping import TRIGGER
from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2, running
from tests.bridges.ros2.genuine.steering import SteeredNode, steered
from tests.executors import LONG, NAME, executor

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

NODE, RUNS = "/seoro_executor", "/seoro_executor/runs"


async def state_with(genuine: SteeredNode, text: str) -> dict[str, str]:
    """Wait until the last run has a state, and return its status."""
    while True:
        states: list[dict[str, str]] = (await genuine.event("message", topic=RUNS))["message"]["status"]
        if states and states[-1]["message"].startswith(text):
            return states[-1]


async def test_genuine_nodes_start_and_stop_runs(ros2: Ros2, router: str, tmp_path: Path) -> None:
    scenarios = tmp_path / "scenarios"
    scenarios.mkdir()
    (scenarios / "long.osc").write_text(LONG)
    with executor(tmp_path) as lab:
        command = [sys.executable, "-m", "seoro", "ros", "serve", str(scenarios), "--on", NAME]
        command += ["--executor", lab.endpoint, "--ros", router]
        async with steered(ros2, router) as genuine, running(command, "Ctrl-C"):
            await genuine.ask("subscribe", topic=RUNS, type=DIAGNOSTICS, durability="transient_local", depth=1)
            with anyio.fail_after(DEADLINE):
                assert not (await call(genuine, "start"))["success"]
                value = {"type": 4, "string_value": "long"}
                found = await genuine.ask(
                    "call",
                    service=f"{NODE}/set_parameters",
                    type="rcl_interfaces/srv/SetParameters",
                    requests=[{"parameters": [{"name": "scenario", "value": value}]}],
                )
                assert found == [{"results": [{"successful": True, "reason": ""}]}]
                started = await call(genuine, "start")
                assert started["success"], started
                running_state = await state_with(genuine, "running")
                assert running_state["hardware_id"] == started["message"]
                assert f"long.osc ({started['message'][:8]}) running" in (await call(genuine, "state"))["message"]
                assert (await call(genuine, "stop"))["success"]
                ended = await state_with(genuine, "cancelled")
                assert ended["message"] == f"cancelled: stopped by the ROS 2 service {NODE}/stop"
            assert NODE in (await genuine.ask("graph"))["nodes"]


async def call(genuine: SteeredNode, name: str) -> dict[str, Any]:
    [answer] = await genuine.ask("call", service=f"{NODE}/{name}", type=TRIGGER, requests=[{}])
    assert isinstance(answer, dict)
    return answer

"""`seoro ros serve`: nodes start and stop runs on an executor."""

from __future__ import annotations

import signal
import subprocess
import sys
from collections.abc import AsyncIterator, Callable, Iterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
import pytest

import seoro
from seoro.bridges.executor.messages import State
from seoro.bridges.ros2.clients.parameters import get_parameters, list_parameters, set_parameter
from seoro.bridges.ros2.errors import NodeRefused
from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.ros2.participant import RosNode, connect
from seoro.bridges.ros2.runs.contract import RunState
from seoro.bridges.ros2.runs.node import DIAGNOSTICS, EXECUTE, LATCHED, status_of
from seoro.bridges.ros2.state.stopping import TRIGGER
from seoro.bridges.ros2.wire import RmwZenoh
from seoro.cli.main import main
from seoro.cli.ros.serve import chosen
from seoro.client.served_runs import ServedRuns
from seoro.concurrency.background import background
from seoro.embed.options import Options
from seoro.errors import UsageError
from tests.executors import LONG, NAME, RunningExecutor, executor
from tests.labs import keyed_executor, make_lab
from tests.routers import routing

DEADLINE = 90.0  # [s]
NODE = "/scenario_execution_control"
SERVED = """import osc.helpers
scenario served:
    pace: speed with:
        keep(it > 0mps)
    do log("pace {pace}")
"""


class Served:
    """An executor, its node in a ROS 2 system, and the folder of scenarios."""

    def __init__(self, router: str, lab: RunningExecutor, process: subprocess.Popen[str], folder: Path) -> None:
        self.router = router
        self.lab = lab
        self.process = process
        self.folder = folder


def command(router: str, endpoint: str, *arguments: str) -> list[str]:
    found = ["ros", "serve", *arguments, "--executor", endpoint, "--ros", f"{router}?dialect=rmw_zenoh"]
    return [sys.executable, "-m", "seoro", *found]


@pytest.fixture(scope="module")
def served(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Served]:
    folder = tmp_path_factory.mktemp("served")
    scenarios = folder / "scenarios"
    scenarios.mkdir()
    for name, text in (("served", SERVED), ("long", LONG), ("broken", "scenario broken:\n    do dance()\n")):
        (scenarios / f"{name}.osc").write_text(text)
    (folder / "secret.osc").write_text(LONG)
    with routing() as router, executor(folder) as lab:
        started = command(router, lab.endpoint, str(scenarios), "--node", NODE)
        with subprocess.Popen(started, stdout=subprocess.PIPE, text=True) as process:
            try:
                assert process.stdout is not None
                assert f"node {NODE} at {router}, domain 0" in process.stdout.readline()
                yield Served(router, lab, process, scenarios)
            finally:
                process.kill()


@asynccontextmanager
async def operator(router: str) -> AsyncIterator[RosNode]:
    """Yield another node of the system."""
    async with (
        connect(router, types=TypeStore.bundled(), dialect=RmwZenoh()) as system,
        system.node("operator") as node,
    ):
        await system.graph.wait_for(lambda graph: graph.servers(f"{NODE}/state"), DEADLINE)
        yield node


async def call(node: RosNode, name: str, type_name: str = TRIGGER, request: Any = None) -> Any:
    async with node.calling(f"{NODE}/{name}", type_name) as client:
        return await client.call(request or {}, DEADLINE)


async def status_with(node: RosNode, is_wanted: Callable[[Any], bool]) -> Any:
    """Return the first states of runs with a property."""
    with anyio.fail_after(DEADLINE):
        async with node.subscribing(f"{NODE}/runs", DIAGNOSTICS, LATCHED) as runs:
            while not is_wanted(found := (await runs.message()).status):
                pass
    return found


async def test_parameters_name_the_scenario_that_starts(served: Served) -> None:
    async with operator(served.router) as node:
        assert await list_parameters(node, NODE) == ["parameters", "scenario"]
        await set_parameter(node, NODE, "scenario", "served")
        await set_parameter(node, NODE, "parameters", "{pace: 0.25mps}")
        assert await get_parameters(node, NODE, ["scenario"]) == {"scenario": "served"}
        with pytest.raises(NodeRefused, match=r"unknown parameter `speed` \(parameters: scenario, parameters\)"):
            await set_parameter(node, NODE, "speed", "1")
        started = await call(node, "start")
        assert started.success, started.message
        found = await status_with(
            node, lambda states: any(each.hardware_id == started.message and each.level == 0 for each in states)
        )
        found = await status_with(node, lambda states: states and states[-1].message == "passed")
        assert found[-1].name == f"{NODE.strip('/')}/served.osc"
        assert found[-1].values[0].value.startswith("seed ")
        assert "served.osc" in (await call(node, "state")).message
    async with seoro.Client(served.lab.endpoint) as client:
        run = await client.run(started.message)
        assert (await run.result()).passed
        [begin] = [record async for record in run.records() if record["kind"] == "run.start"]
        assert begin["parameters"]["pace"] == 0.25


async def test_runs_are_started_and_stopped_as_by_scenario_execution(served: Served) -> None:
    async with (
        operator(served.router) as node,
        node.subscribing(
            f"{NODE}/status", "scenario_execution_interfaces/msg/ScenarioExecutionStatus", LATCHED
        ) as status,
        node.subscribing(
            f"{NODE}/available_scenarios", "scenario_execution_interfaces/msg/ScenarioList", LATCHED
        ) as listed,
    ):
        with anyio.fail_after(DEADLINE):
            scenarios = {each.name: each.scenario_file for each in (await listed.message()).scenarios}
            assert set(scenarios) == {"served", "long", "broken"}
            request = {"scenario": {"name": "long", "scenario_file": scenarios["long"]}}
            assert (await call(node, "execute_scenario", EXECUTE, request)).result
            while (await status.message()).status != 2:
                pass
            await call(node, "stop_scenario", "std_srvs/srv/Empty")
            while (await status.message()).status != 0:
                pass
            ended = (await status_with(node, lambda states: states and states[-1].level == 3))[-1]
        assert ended.message == f"cancelled: stopped by the ROS 2 service {NODE}/stop"
        stopped = await call(node, "stop")
        assert (stopped.success, stopped.message) == (True, "no run is active")


@pytest.mark.parametrize(
    ("name", "reason"),
    [
        ("", "names no scenario file"),
        ("serve", "did you mean `served.osc`"),
        ("../secret.osc", "no scenario file '../secret.osc' in the served folders"),
        ("/etc/passwd", "no scenario file '/etc/passwd' in the served folders"),
        ("broken", "dance"),
    ],
)
async def test_other_files_and_invalid_scenarios_are_refused(served: Served, name: str, reason: str) -> None:
    async with operator(served.router) as node:
        await set_parameter(node, NODE, "scenario", f"'{name}'")
        refused = await call(node, "start")
        assert not refused.success
        assert reason in refused.message
        request = {"scenario": {"scenario_file": name}}
        assert not (await call(node, "execute_scenario", EXECUTE, request)).result


async def test_invalid_parameters_are_refused(served: Served) -> None:
    async with operator(served.router) as node:
        await set_parameter(node, NODE, "scenario", "served")
        for text, reason in (("{pace: ", "invalid `parameters`"), ("[1]", "a mapping")):
            await set_parameter(node, NODE, "parameters", text)
            refused = await call(node, "start")
            assert not refused.success
            assert reason in refused.message
        await set_parameter(node, NODE, "parameters", "''")


async def test_the_end_of_the_command_stops_its_runs(served: Served) -> None:
    started = command(served.router, served.lab.endpoint, str(served.folder), "--node", "/lab/other")
    async with operator(served.router) as node:
        with subprocess.Popen(started, stdout=subprocess.PIPE, text=True) as process:
            try:
                assert process.stdout is not None
                assert "node /lab/other" in process.stdout.readline()
                await set_parameter(node, "/lab/other", "scenario", "long")
                async with node.calling("/lab/other/start", TRIGGER) as client:
                    run = await client.call({}, DEADLINE)
                assert run.success
                process.send_signal(signal.SIGINT)
                assert await anyio.to_thread.run_sync(process.wait) == 0
            finally:
                process.kill()
    async with seoro.Client(served.lab.endpoint) as client:
        verdict = await (await client.run(run.message)).result()
    assert verdict.reason == "the node that started it has ended"


def test_the_status_is_that_of_active_runs_or_of_the_last() -> None:
    def state(state: State, **more: Any) -> RunState:
        return RunState("0", "x.osc", state, **more)

    ended = [state(State.FAILED), state(State.PASSED)]
    assert status_of([]) == status_of(ended) == 0
    assert status_of([*ended, state(State.QUEUED)]) == 1
    assert status_of([*ended, state(State.QUEUED), state(State.RUNNING)]) == 2
    assert status_of([state(State.RUNNING, is_stopping=True), *ended]) == 3
    assert status_of(ended[:1]) == status_of([state(State.RUNNING, is_lost=True)]) == 4
    assert state(State.RUNNING, reason="gone", is_lost=True).text == "unknown: gone"


def test_a_missing_folder_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["ros", "serve", str(tmp_path / "missing")]) == 2
    assert "folder of scenario files not found" in capsys.readouterr().err


def test_the_node_waits_for_an_executor_that_starts_later(tmp_path: Path) -> None:
    with routing() as router:
        started = command(router, f"unixsock-stream/{tmp_path}/hub", str(tmp_path))
        with subprocess.Popen(started, stdout=subprocess.PIPE, text=True) as process:
            try:
                with executor(tmp_path):
                    assert process.stdout is not None
                    assert "node /seoro_executor" in process.stdout.readline()
            finally:
                process.kill()


@pytest.mark.more
async def test_an_executor_that_dies_is_reported(tmp_path: Path) -> None:
    (tmp_path / "long.osc").write_text(LONG)
    with executor(tmp_path) as lab:
        options = Options(timeout=600.0)
        async with seoro.Client(lab.endpoint, patience=0.5) as client, background() as tasks:
            runs = ServedRuns(client, NAME, [tmp_path], options, tasks)
            started = await runs.start("long", "")
            await runs.changed.wait_for(lambda: runs.states()[0].state is State.RUNNING, DEADLINE)
            lab.kill()
            await runs.changed.wait_for(lambda: runs.states()[0].is_lost, DEADLINE)
            assert runs.states()[0].text.startswith("unknown: ")
            assert status_of(runs.states()) == 4
            assert await runs.stop("too late") == []
            assert started.run == runs.states()[0].run


@pytest.mark.parametrize(
    ("names", "wanted", "reason"),
    [
        ([], None, "no executor at here"),
        (["a", "b"], None, "several executors at here"),
        (["a"], "b", "no executor 'b' at here"),
    ],
)
def test_the_executor_has_to_be_known(names: list[str], wanted: str | None, reason: str) -> None:
    with pytest.raises(UsageError, match=reason):
        chosen("here", names, wanted)


@pytest.mark.more
@pytest.mark.parametrize(("who", "succeeds"), [("anna", True), ("vera", False)])  # operator and viewer
async def test_an_executor_with_keys_knows_the_person_of_the_node(
    tmp_path: Path, who: str, succeeds: bool
) -> None:
    """Operators start runs, and are in its audit log; viewers are refused."""
    lab = make_lab(tmp_path / "keys")
    scenarios = tmp_path / "scenarios"
    scenarios.mkdir()
    (scenarios / "long.osc").write_text(LONG)
    with routing() as router, keyed_executor(tmp_path, lab) as running:
        started = command(router, running.endpoint, str(scenarios), "--node", NODE, "--keys", str(lab.keys(who)))
        with subprocess.Popen(started, stdout=subprocess.PIPE, text=True) as process:
            try:
                assert process.stdout is not None
                assert f"node {NODE}" in process.stdout.readline()
                async with operator(router) as node:
                    await set_parameter(node, NODE, "scenario", "long")
                    run = await call(node, "start")
                    assert run.success is succeeds, run.message
                    stopped = await call(node, "stop")
                    assert stopped.success
            finally:
                process.kill()
    if not succeeds:
        assert "vera (viewer) may not send" in run.message
        return
    assert f"stopped by the ROS 2 service {NODE}/stop" in stopped.message
    lines = (tmp_path / "state" / "audit.jsonl").read_text().splitlines()
    assert any(who in line and "submit" in line for line in lines)

"""Services and topics of a node by which other nodes start, stop and follow runs.

Beside `std_srvs`, they have the types of `scenario_execution_interfaces`, and the names that its users know.
"""

from __future__ import annotations

import logging
import time
from collections.abc import AsyncIterator, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from typing import Any, Final

import anyio

from seoro.bridges.executor.messages import State
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.recording.bag_values import time_value
from seoro.bridges.ros2.runs.contract import Runs, RunState
from seoro.bridges.ros2.runs.parameters import TextParameters, serving_parameters
from seoro.bridges.ros2.state.behaviors import ERROR, OK, STALE
from seoro.bridges.ros2.state.publishing import PERIOD
from seoro.bridges.ros2.state.stopping import TRIGGER
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire.qos import Durability, Qos
from seoro.concurrency.background import background
from seoro.errors import SeoroError
from seoro.text.printable import one_line

PACKAGE: Final = "scenario_execution_interfaces"
EXECUTE: Final = f"{PACKAGE}/srv/ExecuteScenario"
DIAGNOSTICS: Final = "diagnostic_msgs/msg/DiagnosticArray"
LATCHED: Final = Qos(depth=1, durability=Durability.TRANSIENT_LOCAL)
STOPPED, STARTING, RUNNING, SHUTTING_DOWN, FAILED = range(5)  # of `ScenarioExecutionStatus`
PARAMETERS: Final = {
    "scenario": "scenario file that ~/start runs, as a path or the name of a file in the served folders",
    "parameters": "values of its parameters, as a YAML mapping such as {robot.goal.x: 3m}",
}
_GOOD: Final = (State.QUEUED, State.RUNNING, State.PASSED)

log = logging.getLogger(__name__)


def status_of(states: Sequence[RunState]) -> int:
    """Return the status in the terms of `ScenarioExecutionStatus`: of active runs, else of the last one."""
    active = [each for each in states if not each.is_over]
    if any(each.is_stopping for each in active):
        return SHUTTING_DOWN
    if active:
        return RUNNING if any(each.state is State.RUNNING for each in active) else STARTING
    is_good = not states or (states[-1].state in (State.PASSED, State.CANCELLED) and not states[-1].is_lost)
    return STOPPED if is_good else FAILED


def level_of(state: RunState) -> int:
    """Return the level of a run in diagnostics, as that of a behavior."""
    if state.is_lost or state.state not in (*_GOOD, State.CANCELLED):
        return ERROR
    return STALE if state.state is State.CANCELLED else OK


def summary_of(states: Sequence[RunState]) -> str:
    """Describe active runs, or the last one, in a line."""
    shown = [each for each in states if not each.is_over] or states[-1:]
    return "; ".join(f"{each.file} ({each.run[:8]}) {each.text}" for each in shown) or "no run was started"


class RunServices:
    """Handlers of the services of a node.

    Args:
        name: Full name of the node, for the reason of a stop.
        runs: The runs.
        parameters: Parameters of the node, for `~/start`.
    """

    def __init__(self, name: str, runs: Runs, parameters: TextParameters) -> None:
        self._name = name
        self._runs = runs
        self._parameters = parameters

    async def execute(self, request: Message) -> Mapping[str, Any]:
        """Start the scenario file of a request; its `name` counts if it has none."""
        scenario = request.scenario
        return {"result": (await self._start(scenario.scenario_file or scenario.name, ""))["success"]}

    async def start(self, _request: Message) -> Mapping[str, Any]:
        """Start the scenario of the parameters."""
        return await self._start(self._parameters.text("scenario"), self._parameters.text("parameters"))

    async def _start(self, name: str, parameters: str) -> Mapping[str, Any]:
        try:
            started = await self._runs.start(name, parameters)
        except SeoroError as error:
            reason = "\n".join((str(error), *getattr(error, "__notes__", ())))
            log.warning("cannot start %s: %s", one_line(name) or "a scenario without a name", reason)
            return {"success": False, "message": reason}
        log.info("%s: run %s", started.file, started.run)
        return {"success": True, "message": started.run}

    async def stop(self, _request: Message) -> Mapping[str, Any]:
        """Stop all runs of the node."""
        try:
            stopped = await self._runs.stop(f"stopped by the ROS 2 service {self._name}/stop")
        except SeoroError as error:
            return {"success": False, "message": str(error)}
        is_done = all(each.state.is_final for each in stopped)
        return {"success": is_done, "message": summary_of(stopped) if stopped else "no run is active"}

    async def stop_without_reply(self, request: Message) -> Mapping[str, Any]:
        """Stop all runs of the node; the response is empty."""
        reply = await self.stop(request)
        if not reply["success"]:
            log.warning("cannot stop: %s", reply["message"])
        return {}

    async def state(self, _request: Message) -> Mapping[str, Any]:
        """Describe active runs, or the last one."""
        return {"success": True, "message": summary_of(self._runs.states())}


@asynccontextmanager
async def serving_runs(node: RosNode, runs: Runs) -> AsyncIterator[None]:
    """Serve the services and topics of runs, until the end of the block."""
    async with AsyncExitStack() as stack:
        parameters = await stack.enter_async_context(serving_parameters(node, PARAMETERS))
        status = await stack.enter_async_context(
            node.publishing("~/status", f"{PACKAGE}/msg/ScenarioExecutionStatus", LATCHED)
        )
        details = await stack.enter_async_context(node.publishing("~/runs", DIAGNOSTICS, LATCHED))
        listed = await stack.enter_async_context(
            node.publishing("~/available_scenarios", f"{PACKAGE}/msg/ScenarioList", LATCHED)
        )
        files = await anyio.to_thread.run_sync(runs.files)
        listed.publish({"scenarios": [{"name": each.stem, "scenario_file": str(each)} for each in files]})
        tasks = await stack.enter_async_context(background())
        tasks.start_soon(_publish, runs, status, details, node.node.full_name)
        services = RunServices(node.node.full_name, runs, parameters)
        for name, type_name, handler in (
            ("execute_scenario", EXECUTE, services.execute),
            ("start", TRIGGER, services.start),
            ("stop", TRIGGER, services.stop),
            ("stop_scenario", "std_srvs/srv/Empty", services.stop_without_reply),
            ("state", TRIGGER, services.state),
        ):
            await stack.enter_async_context(node.serving(f"~/{name}", type_name, handler))
        yield


async def _publish(runs: Runs, status: Publication, details: Publication, source: str) -> None:
    """Publish each change of the states, without end."""
    shown: Sequence[RunState] | None = None
    while True:
        states = runs.states()
        if states == shown:
            await runs.changed.wait()
            continue
        shown = states
        status.publish({"status": status_of(shown)})
        details.publish(_diagnostics(shown, source))
        await anyio.sleep(PERIOD)


def _diagnostics(states: Sequence[RunState], source: str) -> Mapping[str, Any]:
    statuses = [
        {
            "level": level_of(each),
            "name": f"{source.strip('/')}/{each.file}",
            "message": each.text,
            "hardware_id": each.run,
            "values": [{"key": "start", "value": each.announcement}] if each.announcement else [],
        }
        for each in states
    ]
    return {"header": {"stamp": time_value(time.time_ns())}, "status": statuses}

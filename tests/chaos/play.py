"""Execution of a round on a stage, and collection of the observations after it."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path
from typing import Any

import anyio

import seoro
from seoro.client.lab import LabControl
from tests.chaos.oracle import Found, FoundRun, Received
from tests.chaos.plan import LENGTH, Fault, Round, Submission
from tests.chaos.stage import Stage, until

RECOVERY = 45.0  # [s] until runs have ended, robots are free and nothing is left
SLOW = 0.15  # [s] of delay each way
SCENARIOS = {
    "log": 'import osc.helpers\nscenario main:\n    do log("done")\n',
    "wait": "import osc.types\nscenario main:\n    do wait elapsed({seconds}s)\n",
    "fail": (
        "import osc.types\nscenario main:\n    do serial:\n        wait elapsed({seconds}s)\n        emit fail\n"
    ),
    "drive": (
        "import osc.driving\nscenario main:\n    robot: differential_drive_robot\n"
        "    do robot.drive(angular: 0.5radps, duration: {seconds}s)\n"
    ),
}
LAB = "simulators:\n  hall: {{connect: {endpoint}, name: hall}}\nrobots:\n  robot: {{in: hall, as: {robot}}}\n"


class Client:
    """A client process, and its output.

    Args:
        submission: Its submission.
        stage: The lab.
        folder: Folder of the round.
    """

    def __init__(self, submission: Submission, stage: Stage, folder: Path) -> None:
        self.submission = submission
        scenario = folder / f"client_{submission.number}.osc"
        scenario.write_text(SCENARIOS[submission.kind].format(seconds=submission.seconds))
        self._arguments = [stage.links["clients"].endpoint, submission.executor, str(scenario)]
        if submission.robot:
            lab = folder / f"lab_{submission.number}.yaml"
            lab.write_text(LAB.format(endpoint=stage.links["clients"].endpoint, robot=submission.robot))
            self._arguments += [str(lab), "60" if submission.waits else ""]
        self._environment = stage.parts["router"].environment
        self._process: subprocess.Popen[str] | None = None

    def start(self) -> None:
        """Submit the scenario."""
        command = [sys.executable, "-m", "tests.chaos.client", *self._arguments]
        self._process = subprocess.Popen(
            command, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL, env=self._environment, text=True
        )

    def kill(self) -> None:
        """Kill the client."""
        if self._process is not None:
            self._process.kill()

    def received(self) -> Received:
        """Return the reports of the client; kill it if it still waits."""
        if self._process is None:
            return Received(self.submission)
        try:
            out, _ = self._process.communicate(timeout=RECOVERY)
        except subprocess.TimeoutExpired:
            self._process.kill()
            out, _ = self._process.communicate()
        known: dict[str, str] = {}
        for line in out.splitlines():
            with suppress(ValueError):
                known |= json.loads(line)
        return Received(
            self.submission,
            known.get("submitted", ""),
            known.get("verdict", ""),
            known.get("invalid", ""),
            known.get("reason", known.get("error", "")),
        )


def play(drawn: Round, stage: Stage, folder: Path) -> Found:
    """Play a round.

    Args:
        drawn: The round.
        stage: The lab, which is healthy before and after.
        folder: Folder for files of the round, which does not exist yet.
    """
    folder.mkdir(parents=True)
    clients = [Client(each, stage, folder) for each in drawn.submissions]
    steps: list[tuple[float, Callable[[], object]]] = [(client.submission.at, client.start) for client in clients]
    for fault in drawn.faults:
        steps += _steps(fault, stage, clients)
    began = time.monotonic()
    for at, step in sorted(steps, key=lambda item: item[0]):
        time.sleep(max(0.0, began + at - time.monotonic()))
        step()
    time.sleep(max(0.0, began + LENGTH - time.monotonic()))
    stage.heal()
    received = [client.received() for client in clients]
    return anyio.run(_look, stage, folder, received)


def _steps(fault: Fault, stage: Stage, clients: list[Client]) -> list[tuple[float, Callable[[], object]]]:
    """Return the actions that inject and end a fault, with their times."""
    begin, end = fault.at, fault.at + fault.seconds
    match fault.what:
        case "kill":
            part = stage.parts[fault.who]
            return [(begin, part.kill), (end, lambda: _start_again(part.name, stage))]
        case "freeze":
            part = stage.parts[fault.who]
            return [(begin, lambda: part.signal(signal.SIGSTOP)), (end, lambda: part.signal(signal.SIGCONT))]
        case "cut":
            link = stage.links[fault.who]
            return [(begin, lambda: link.set(cut=True)), (end, link.set)]
        case "slow":
            link = stage.links[fault.who]
            return [(begin, lambda: link.set(delay=SLOW)), (end, link.set)]
        case "kill_client":
            return [(begin, clients[int(fault.who)].kill)]
        case "kill_run":
            return [(begin, lambda: _kill(stage.runs_of(fault.who)[1:][-1:]))]
        case "kill_fork_server":
            return [(begin, lambda: _kill(stage.runs_of(fault.who)[:1]))]


def _start_again(name: str, stage: Stage) -> None:
    """Start a part that was killed; the end of the round waits until it is ready."""
    if stage.parts[name].process is None:
        stage.parts[name].start()


def _kill(pids: list[int]) -> None:
    for pid in pids:
        with suppress(ProcessLookupError):
            os.kill(pid, signal.SIGKILL)


# ---------------------------------------------------------------- what is found


async def _look(stage: Stage, folder: Path, received: list[Received]) -> Found:
    """Wait until the lab has recovered, and look at it."""
    endpoint = stage.links["clients"].endpoint
    runs: list[FoundRun] = []
    unreachable: list[str] = []
    end = time.monotonic() + RECOVERY
    while True:
        try:
            async with seoro.Client(endpoint) as client:
                runs = await _runs(client, folder)
                missing = {"lab-a", "lab-b"} - set(await client.executors())
            held = await _held(endpoint)
        except seoro.SeoroError as error:
            held, missing = {"?": str(error)}, {"lab-a", "lab-b"}
        open_runs = [run for run in runs if run.state in ("queued", "running")]
        if time.monotonic() > end or not (held or missing or open_runs):
            break
        await anyio.sleep(0.3)
    unreachable = sorted(missing)
    left: list[str] = []
    if not await anyio.to_thread.run_sync(until, lambda: not stage.strangers(), RECOVERY):
        left = stage.strangers()
    left += [str(path) for path in (stage.folder / "tmp").iterdir() if path.name.startswith("seoro-")]
    return Found(received, runs, held, left, unreachable)


async def _runs(client: seoro.Client, folder: Path) -> list[FoundRun]:
    found = []
    for name in ("lab-a", "lab-b"):
        for run in await client.runs(name, limit=1000):
            if str(folder) in run.info.file:
                records: list[dict[str, Any]] = []
                if run.state.is_final:
                    records = [record async for record in run.records_so_far()]
                found.append(
                    FoundRun(run.id, name, Path(run.info.file).name, run.state.value, run.info.reason, records)
                )
    return found


async def _held(endpoint: str) -> dict[str, str]:
    """Robots that are held, or whose node cannot be asked."""
    held: dict[str, str] = {}
    members = await LabControl((endpoint,)).status()
    for member in members:
        if member.state is not None:
            held |= {robot.name: robot.holder for robot in member.state.robots if robot.holder}
    if not any(member.state is not None and member.state.robots for member in members):
        held["hall"] = "its node does not answer"
    return held

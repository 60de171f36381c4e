"""One run of a campaign, from its plan to its row."""

from __future__ import annotations

import asyncio
import platform
import time
from contextlib import suppress
from dataclasses import replace
from datetime import UTC, datetime
from pathlib import Path
from typing import Any, Final

from seoro.bridges.wire.message import Empty
from seoro.bridges.wire.outputs import GET_MEASUREMENTS
from seoro.campaign.identity import row_of
from seoro.campaign.runs import End, Planned, Row
from seoro.campaign.space.feasible import Feasibility
from seoro.campaign.store.folder import KEPT, TRACE
from seoro.campaign.work.job import Job
from seoro.campaign.work.measurements import of_robots, reason_key, values_of
from seoro.campaign.work.outputs import recording, save_artifacts
from seoro.campaign.work.processes import processor_time
from seoro.campaign.work.scratch import Scratch
from seoro.campaign.work.watching import Watching
from seoro.embed.options import Options
from seoro.embed.preparation import prepare
from seoro.embed.runs import Run
from seoro.errors import CONFLICT, BackendError, InvalidScenario, UsageError
from seoro.lab.selectors import split_selectors
from seoro.runtime.verdict import RunStatus

MOST_REPORTS: Final = 100  # of a worker: each takes 0.1 MB, and `seoro report` writes further ones
DYING: Final = 20  # looks at a simulator that has lost the connection
DYING_PERIOD: Final = 0.05  # [s] between two looks
_NOTHING: Final[dict[str, Any]] = {}


class Stopped(Exception):
    """The run was stopped with its campaign; it will be made again."""


class SimulatorDied(Exception):
    """The simulator of the worker has died during a run, which will be made again."""


class Worker:
    """Makes runs, one after another; close it at the end.

    Args:
        job: Shared data of all runs.
        name: Name of the worker.
        endpoint: Endpoint of its simulator; empty to let each run start its own.
        simulator: Process id of that simulator.
    """

    def __init__(self, job: Job, name: str, endpoint: str = "", simulator: int | None = None) -> None:
        self._job = job
        self._name = name
        self._reports = 0
        self._endpoint = endpoint
        self._simulator = simulator
        self._host = platform.node()
        self._scratch = Scratch(job.folder / KEPT / f".{name}")
        self._run: Run | None = None
        self._is_stopped = False
        self._is_lost = False  # the simulator, maybe

    def close(self) -> None:
        """Remove the files of the present run."""
        self._scratch.close()

    @property
    def has_run(self) -> bool:
        """Whether a run has begun, and is not over."""
        return self._run is not None

    def stop(self, reason: str = "the campaign is stopped") -> None:
        """Stop the present run, with its clean-up, and begin no other."""
        self._is_stopped = True
        if self._run is not None:
            self._run.stop(reason)

    def halt(self, reason: str) -> None:
        """Stop the present run without further motion of its robots."""
        self._is_stopped = True
        if self._run is not None:
            self._run.halt(reason)

    async def make(self, planned: Planned) -> Row:
        """Make a run; returns its row.

        Raises:
            Stopped: `stop` was called.
            SimulatorDied: The worker has no simulator any more.
        """
        started = datetime.now(UTC).isoformat(timespec="milliseconds")
        cpu, wall, of_simulator = time.process_time(), time.monotonic(), self._simulator_time()
        end = await self._end(planned)
        if self._is_stopped:
            raise Stopped
        if self._simulator is not None and await self._has_simulator_died():
            raise SimulatorDied
        return row_of(
            planned,
            self._job.digest,
            self._job.version,
            host=self._host,
            worker=self._name,
            started=started,
            cpu=round(time.process_time() - cpu, 6),
            wall_duration=round(time.monotonic() - wall, 6),
            sim_cpu=round(self._simulator_time() - of_simulator, 3),
            **end,
        )

    async def _end(self, planned: Planned) -> dict[str, Any]:
        """Make a run; returns the fields of its row that depend on how it ends."""
        files = self._scratch.empty()
        watching = Watching(files / TRACE if self._job.keep != "none" else None)
        try:
            fields = await self._watched(planned, watching, files)
            if self._is_kept(fields["status"]):
                watching.save()
                if fields["status"] is not End.PASSED and self._reports < MOST_REPORTS:
                    self._reports += 1
                    _report(files)
                folder = self._job.folder / KEPT / f"{planned.number:06}"
                self._scratch.keep_as(folder)
                fields["folder"] = folder.relative_to(self._job.folder).as_posix()
            return fields
        finally:
            watching.close()

    def _is_kept(self, end: End) -> bool:
        keep = self._job.keep
        if end is End.IMPOSSIBLE or keep == "none":
            return False
        return keep == "all" or end is not End.PASSED

    async def _watched(self, planned: Planned, watching: Watching, folder: Path) -> dict[str, Any]:
        options = self._options(planned, watching, folder)
        try:
            async with prepare(self._job.scenario, options) as run:
                self._run = run
                if self._is_stopped:
                    return {"status": End.CANCELLED}
                film = recording(run, self._job.film, folder)
                async with film as recorded, run.running(self._job.limit):
                    verdict = await run.result()
                if recorded is not None:
                    verdict = recorded.checked(verdict)
                if self._is_kept(End.of(verdict.status)):
                    await save_artifacts(run, folder, parquet=self._job.parquet)
                measured = {**dict(await self._measured(run)), **watching.samples}
        except UsageError as error:
            if error.code == CONFLICT:
                return {"status": End.IMPOSSIBLE, "values": planned.values, "reason": error.message}
            return _error(planned, error.message, str(error.span or ""))
        except (InvalidScenario, BackendError) as error:
            self._is_lost = isinstance(error, BackendError)
            return _error(planned, str(error).splitlines()[0])
        finally:
            self._run = None
        if verdict.status is RunStatus.ERROR and not self._is_feasible(planned):  # found when it was invoked
            return {"status": End.IMPOSSIBLE, "values": planned.values, "reason": verdict.reason}
        return {
            "status": End.of(verdict.status),
            "values": values_of(planned.values, run.parameters),
            "duration": verdict.duration,
            "reason": verdict.reason,
            "reason_key": reason_key(verdict.reason),
            "margin": verdict.margin,
            "where": str(verdict.span or ""),
            "trace_sha": watching.digest,
            "measured": measured,
            "coverage": tuple(item.plain() for item in verdict.coverage),
        }

    def _is_feasible(self, planned: Planned) -> bool:
        """Return whether constraints allow the values of a run."""
        options = self._job.options
        overrides, _ = split_selectors(options.overrides)
        return Feasibility(self._job.scenario, options.name, overrides, options.constraints)(planned.values)

    def _options(self, planned: Planned, watching: Watching, folder: Path) -> Options:
        options = self._job.options
        simulator = options.simulator
        if simulator is not None and self._endpoint:
            simulator = replace(simulator, name=None, endpoint=self._endpoint)
        return replace(
            options,
            seed=planned.seed,
            overrides={**options.overrides, **planned.values},
            simulator=simulator,
            observers=(watching,),
            output_directory=folder,
        )

    async def _measured(self, run: Run) -> dict[str, Any]:
        """Fetch the measurements of the simulator; none without one, or if it is lost."""
        if run.simulator is None:
            return _NOTHING
        try:
            return dict(of_robots(await run.simulator.ask(GET_MEASUREMENTS, Empty())))
        except BackendError:
            self._is_lost = True
            return _NOTHING

    async def _has_simulator_died(self) -> bool:
        """Return whether the simulator has died; a process that dies closes its connections first."""
        for _ in range(DYING if self._is_lost else 1):
            if processor_time(self._simulator) is None:
                return True
            if self._is_lost:
                await asyncio.sleep(DYING_PERIOD)
        self._is_lost = False
        return False

    def _simulator_time(self) -> float:
        """Return the processor time of the simulator so far [s]; 0 without one."""
        return processor_time(self._simulator) or 0.0


def _error(planned: Planned, reason: str, where: str = "") -> dict[str, Any]:
    return {
        "status": End.ERROR,
        "values": planned.values,
        "reason": reason,
        "reason_key": reason_key(reason),
        "where": where,
    }


def _report(folder: Path) -> None:
    """Write the report of a run beside its trace, so that a failure can be looked at without a command."""
    from seoro.report.page import REPORT, NoRecords, write_report  # noqa: PLC0415 - only if a run fails

    with (
        suppress(OSError, NoRecords),
        (folder / TRACE).open("rb") as trace,
        (folder / REPORT).open("w", encoding="utf-8", newline="\n") as output,
    ):
        write_report(trace, folder, output)

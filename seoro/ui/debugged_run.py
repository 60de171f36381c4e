"""`DebuggedRun`: the run of a debug adapter among the runs of the site."""

from __future__ import annotations

import secrets
import shutil
import time
from collections.abc import Callable, Mapping
from contextlib import ExitStack
from dataclasses import replace
from pathlib import Path
from typing import Any, Final

import anyio.to_thread

from seoro.runtime.execution.outputs import TRACE
from seoro.ui.answers import RequestError, as_request_error
from seoro.ui.local_runs import describe
from seoro.ui.registry import Known, LocalSource, Run, Status, local_id
from seoro.ui.site import Site

MOST_KEPT: Final = 20  # results of debugged runs
PLACE: Final = "debugger"
_FOLDER: Final = "debugged"  # in the state folder of the site


class DebuggedRun:
    """The run of a debug adapter: its folder, and its entry in the list of runs.

    Args:
        site: The site.
        stop: Stops the run without waiting.
    """

    def __init__(self, site: Site, stop: Callable[[], object]) -> None:
        self._site = site
        self._stop = stop
        self._trace: Path | None = None
        self._run: Run | None = None
        self._program = Path()
        self._active = ExitStack()
        self.is_registered = False

    @property
    def id(self) -> str:
        """Id of the run; empty before it has started."""
        return self._run.id if self._run is not None and self.is_registered else ""

    @property
    def data(self) -> Mapping[str, Any]:
        """The run, its file, and the folder of its relative paths, for a page."""
        return {"run": self.id, "program": str(self._program), "cwd": str(self._program.parent)}

    async def prepare(self, arguments: object) -> Mapping[str, Any]:
        """Complete the settings of a run: absolute paths, and a folder for the results.

        Args:
            arguments: Settings of the page.

        Raises:
            RequestError: The file is not in the list of scenarios, or there is a run already.
        """
        if self.is_registered:
            raise RequestError(409, "the session has a run already", "start another session")
        given = arguments if isinstance(arguments, dict) else {}
        found = {name: value for name, value in given.items() if value not in (None, "")}
        name = str(found.get("program", ""))
        program = await anyio.to_thread.run_sync(self._site.scenarios.path, name)
        try:
            output = await anyio.to_thread.run_sync(_new_folder, self._site.state / _FOLDER)
        except OSError as error:
            raise as_request_error(error) from error
        self._trace, self._program = output / TRACE, program
        self._run = Run(
            id=local_id(self._trace),
            place=PLACE,
            kind="folder",
            scenario=str(found.get("scenario", "")),
            file=name,
            status=Status.RUNNING,
            started=time.time(),
            folder=str(output),
        )
        return {**found, "program": str(program), "cwd": str(program.parent), "output": str(output)}

    def register(self) -> None:
        """Add the run to those of the site, also for its emergency stop."""
        if self._run is None or self._trace is None:
            return
        self.is_registered = True
        self._site.runs.update([Known(self._run, LocalSource(self._trace, self._trace.parent))])
        self._active.enter_context(self._site.own_runs.active(f"the debugged run of {self._run.file}", self._stop))

    async def end(self) -> None:
        """Update the run from its trace, which has ended."""
        self._active.close()
        if not self.is_registered or self._run is None or self._trace is None or self._run.status.is_final:
            return
        try:
            found = await anyio.to_thread.run_sync(describe, self._trace, self._site.folders)
        except OSError:  # the run did not start
            found = replace(self._run, status=Status.CANCELLED)
        if not found.status.is_final:
            found = replace(found, status=Status.KILLED)
        self._run = replace(found, place=PLACE, file=self._run.file)
        self._site.runs.update([Known(self._run, LocalSource(self._trace, self._trace.parent))])


def _new_folder(parent: Path) -> Path:
    """Make a folder for the results of a run; the oldest ones are deleted.

    Raises:
        OSError: It cannot be made.
    """
    parent.mkdir(parents=True, exist_ok=True, mode=0o700)
    before = sorted(parent.iterdir(), key=lambda path: path.stat().st_mtime)
    for path in before[: -MOST_KEPT + 1]:
        shutil.rmtree(path, ignore_errors=True)
    folder = parent / secrets.token_hex(8)
    folder.mkdir(mode=0o700)
    return folder

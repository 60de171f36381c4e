"""Jobs: what the process of a run gets to know of it."""

from __future__ import annotations

from seoro.bridges.executor import messages as wire
from seoro.executor.frames import Job
from seoro.executor.limits import Limits
from seoro.executor.store import RunFolder


def make_job(
    manifest: wire.Manifest, folder: RunFolder, limits: Limits, *, can_sandbox: bool, is_dry: bool = False
) -> Job:
    """Make the job of a run, and the folders that its process writes to.

    Args:
        manifest: Of the bundle.
        folder: Folder of the run, two levels below that of the executor, which is hidden from the process.
        limits: Of the client that submitted it.
        can_sandbox: Whether this executor can sandbox runs.
        is_dry: Whether the process ends where the run would begin.

    Raises:
        OSError: A folder cannot be made.
    """
    for each in (folder.output, folder.home):
        each.mkdir(exist_ok=True)
    return Job(
        manifest=manifest,
        files=str(folder.files),
        output=str(folder.output),
        log=str(folder.log),
        home=str(folder.home),
        largest_file=limits.largest_file,
        memory=limits.largest_memory,
        processes=limits.processes,
        allowed=limits.allowed,
        reach=limits.reached,
        environment=limits.variables,
        is_sandboxed=can_sandbox and limits.sandbox != "off",
        hidden=(str(folder.path.parents[1]),),
        is_dry=is_dry,
    )

"""Jobs: the description of a run for its process."""

from __future__ import annotations

from typing import TYPE_CHECKING

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire.message import Message

if TYPE_CHECKING:
    from seoro.executor.limits import Limits
    from seoro.executor.storage.run_folder import RunFolder


class Job(Message):
    """A run to execute: its files, and the permissions and limits of its scenario."""

    manifest: wire.Manifest
    files: str  # folder with the bundle
    output: str  # folder for output files
    log: str  # file for printed output
    home: str  # home folder of its programs, removed after the run
    largest_file: int  # [bytes]
    memory: int | None = None  # [bytes] of all its processes; None for no limit
    processes: int | None = None  # limit of their number; None for no limit
    allowed: tuple[str, ...]
    reach: tuple[str, ...] = ()  # allowed endpoints of other machines
    environment: tuple[str, ...] = ()  # further variables of the executor that the run sees
    is_dry: bool = False  # whether it is a dry run
    is_sandboxed: bool = False
    campaign: wire.CampaignWorker | None = None  # makes the runs of a campaign
    hidden: tuple[str, ...] = ()  # folders of the executor that are hidden from a sandboxed run


def make_job(
    manifest: wire.Manifest,
    folder: RunFolder,
    limits: Limits,
    *,
    can_sandbox: bool,
    is_dry: bool = False,
    campaign: wire.CampaignWorker | None = None,
) -> Job:
    """Create the job of a run, and the folders that its process writes to.

    Args:
        manifest: Manifest of the bundle.
        folder: Folder of the run, two levels below that of the executor, which is hidden from the process.
        limits: Limits of the client.
        can_sandbox: Whether this executor can sandbox runs.
        is_dry: Whether the process ends before the run begins.
        campaign: Campaign whose runs the process makes; None for one run.

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
        campaign=campaign,
    )

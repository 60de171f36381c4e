"""Loading of the scenario and the options of a job, within the permissions of its sender."""

from __future__ import annotations

import os
from dataclasses import replace
from functools import partial
from pathlib import Path

from seoro.bundle.paths import make_locator
from seoro.bundle.unpack import read_options
from seoro.embed import check_file
from seoro.embed.options import Options
from seoro.embed.scenarios import Scenario
from seoro.executor.job import Job
from seoro.executor.permissions import keeping_to, reader_of, vet_endpoints, vet_plan, vet_sources
from seoro.executor.process.control import Control
from seoro.executor.process.frames import Frame
from seoro.executor.process.trace_pipe import TracePipe
from seoro.files.path_mapping import Locate
from seoro.lang.loader import Reader


def load_run(job: Job, trace: TracePipe, requests: Control) -> tuple[Scenario, Options]:
    """Load a scenario, and change into its working directory.

    Args:
        job: The job.
        trace: Observer of the run, and pipe to the executor.
        requests: Requests of the executor.

    Returns:
        The scenario, and the options of its run.

    Raises:
        InvalidScenario, UsageError: The scenario or an option is invalid, or not permitted.
    """
    files, manifest = Path(job.files), job.manifest
    os.chdir(files / manifest.directory)
    read, locate = reader_of(files), make_locator(manifest.root, files)
    load = partial(_checked, read=read, locate=locate, job=job)
    scenario = load(files / manifest.entry, manifest.shown)
    given = read_options(manifest, _as_seen_from(Path(manifest.directory)), locate)
    options = replace(
        given,
        leasing=replace(
            given.leasing,
            on_wait=partial(trace.send, Frame.WAITS),
            on_acquired=partial(requests.acquire_slot, partial(trace.send, Frame.READY)),
        ),
        observers=(trace,),
        output_directory=Path(job.output),
        vet=partial(vet_plan, allowed=job.allowed),
        locate=keeping_to((files, Path(job.output)), locate, job.allowed),
        load=lambda path: load(locate(path), str(path)),
    )
    vet_endpoints(options, job.allowed, job.reach)
    return scenario, options


def _checked(path: Path, shown: str, read: Reader, locate: Locate, job: Job) -> Scenario:
    """Load a scenario of the bundle, and check its permissions."""
    vet = partial(vet_sources, allowed=job.allowed)
    return check_file(path, name=shown, read=read, locate=locate, vet=vet).without_errors()


def _as_seen_from(directory: Path) -> Path:
    """Return the root of a bundle relative to a folder in it, so that messages show the paths of the user."""
    return Path(*[".."] * len(directory.parts))

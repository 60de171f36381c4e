"""Number of simultaneous runs of a scenario."""

from __future__ import annotations

import os
from pathlib import Path

from seoro.embed.options import Options
from seoro.errors import UsageError


def simultaneous_runs(options: Options, wanted: int | None) -> int:
    """Return the number of simultaneous runs: one if they share robots or a simulator.

    Args:
        options: Options that all runs share.
        wanted: Number that the user gives; None for one run per processor.

    Raises:
        UsageError: The runs cannot be simultaneous.
    """
    shared = shared_place(options)
    if shared is None:
        return wanted or len(os.sched_getaffinity(0))
    place, hint = shared
    if wanted not in (None, 1):
        raise UsageError(f"runs {place} are sequential", help=hint)
    return 1


def shared_place(options: Options) -> tuple[str, str] | None:
    """Return the place that all runs share, so that they are sequential, and a hint; None without one."""
    if options.ros is not None:
        return "on one robot", "use `--jobs 1`"
    if options.simulator is not None and options.simulator.endpoint is not None:
        return "on one simulator", "use `--sim`, or `--jobs 1`"
    if options.lab is not None and _is_shared(options.lab.file):
        return "in this lab", "leave out `--jobs`"
    return None


def _is_shared(lab: Path) -> bool:
    """Return whether all runs share the robots or the simulator of a lab."""
    from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file

    read = read_lab(lab)
    return bool(read.bridges) or (read.simulator is not None and read.simulator[1].connect is not None)

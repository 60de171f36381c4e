"""Resource limits of the kernel for the processes of a run, in addition to those of the executor.

The executor measures runs twice a second. These limits bound faster growth: memory of a process, and processes and
threads of a run. They are higher than those of the policy, so that ordinary runs reach the latter first, whose
messages name the limit.
"""

from __future__ import annotations

import os
import resource
import signal
from typing import Final

from seoro.executor.job import Job

RESERVED: Final = 1 << 30
"""Reserved but unused memory of a process [bytes]: stacks of threads, and pools of allocators.

Measured: Zenoh and MuJoCo reserve 0.05 to 0.25 GiB.
"""
TASKS: Final = 32
"""Threads of a process, on average, that a run with all its processes may have; Zenoh has 10 to 20."""


def limit_by_kernel(job: Job) -> None:
    """Set the limits of this process and its children.

    `RLIMIT_DATA` counts memory that is private and writable, for each process alone.

    Args:
        job: The run.
    """
    _lower(resource.RLIMIT_CORE, 0)
    _lower(resource.RLIMIT_FSIZE, job.largest_file)
    signal.signal(signal.SIGXFSZ, signal.SIG_IGN)  # so that writing fails, with a reason
    if job.memory is not None:
        _lower(resource.RLIMIT_DATA, job.memory + RESERVED)


def limit_tasks(job: Job) -> None:
    """Set the limit of processes and threads of a run, from within its sandbox.

    `RLIMIT_NPROC` counts those of a user in a user namespace, and each sandbox has its own; outside, it would
    count all of the account. The kernel exempts root, also in a sandbox that root has made.

    Args:
        job: The run.
    """
    if job.processes is not None:
        _lower(resource.RLIMIT_NPROC, job.processes * TASKS)


def why_unlimited(*, is_sandboxed: bool) -> str:
    """Return the reason why the kernel does not limit the number of processes here; empty if it does."""
    if not is_sandboxed:
        return "runs have no sandbox"
    return "it exempts root" if os.geteuid() == 0 else ""


def _lower(which: int, value: int) -> None:
    _, most = resource.getrlimit(which)
    limit = value if most == resource.RLIM_INFINITY else min(value, most)
    resource.setrlimit(which, (limit, limit))

"""Command line of the sandbox of a run, which determines what its processes see of the machine.

Bubblewrap (`bwrap`) creates an unprivileged user and namespaces for mounts, processes and, unless the policy
allows `network`, the network. The sandbox contains the system's programs, this Python with its packages, the
bundle, and the folders that the run may write. It contains neither home folders, keys, other runs, nor sockets of
the system. `enter.py` enters it, and `broker.py` connects it to allowed endpoints.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Collection, Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import Final

from seoro.executor.job import Job
from seoro.executor.permissions import FILES, NETWORK
from seoro.executor.sandbox.bubblewrap import NAMESPACES, PROGRAM

TEMPORARY: Final = "tmp"  # in the home folder of a run, its /tmp
_SYSTEM: Final = ("/usr", "/bin", "/sbin", "/lib", "/lib32", "/lib64", "/libx32", "/etc", "/opt", "/sys")
_DEVICES: Final = (
    *("/dev/null", "/dev/zero", "/dev/full", "/dev/random", "/dev/urandom"),
    *(
        "/dev/dri",
        "/dev/kfd",
        "/dev/nvidia0",
        "/dev/nvidiactl",
        "/dev/nvidia-modeset",
        "/dev/nvidia-uvm",
    ),  # cameras
)
_NAMES: Final = "/run/systemd/resolve"  # of other machines, where there is a network
_PATHS: Final = ("PYTHONPATH", "AMENT_PREFIX_PATH")
# Settings of the kernel, which checks the user for them, not privileges: root could change them from within.
_KERNEL: Final = tuple(
    f"/proc/{name}" for name in ("sys", "sysrq-trigger", "irq", "bus", "fs", "acpi", "scsi", "mtrr")
)
SHARED: Final = str(256 << 20)  # [bytes] of /dev/shm


def command(job: Job, hidden: Collection[Path]) -> list[str]:
    """Return the command that creates the sandbox of a run, without the program to start.

    Args:
        job: The run.
        hidden: Folders of the executor that are hidden from the run.
    """
    made = [PROGRAM, *NAMESPACES, "--die-with-parent"]
    if NETWORK not in job.allowed:
        made.append("--unshare-net")
    sees_all = FILES in job.allowed
    visible = (Path("/"),) if sees_all else visible_folders()
    temporary = ["--bind", f"{job.home}/{TEMPORARY}", "/tmp"]  # noqa: S108 - in the sandbox
    made += ["--ro-bind", "/", "/", *temporary] if sees_all else temporary  # before what may be below
    for path in () if sees_all else visible:
        if path.is_symlink():
            made += ["--symlink", str(path.readlink()), str(path)]
        else:
            made += ["--ro-bind", str(path), str(path)]
    if NETWORK in job.allowed:
        made += ["--ro-bind-try", _NAMES, _NAMES]
    made += ["--proc", "/proc", "--tmpfs", "/dev", "--size", SHARED, "--tmpfs", "/dev/shm"]  # noqa: S108 - in the sandbox
    for name in _KERNEL:
        made += ["--ro-bind-try", name, name]
    for device in _DEVICES:
        made += ["--dev-bind-try", device, device]
    for folder in hidden:
        if folder.exists() and any(folder.is_relative_to(path) for path in visible):
            made += ["--tmpfs", str(folder)]
    made += ["--ro-bind", job.files, job.files]
    for written in (job.output, job.home):
        made += ["--bind", written, written]
    return [*made, "--remount-ro", "/dev", "--remount-ro", "/"]


@cache
def visible_folders() -> tuple[Path, ...]:
    """Return the folders that all runs see; found once, before processes are forked."""
    return (*_system(), *_python(os.environ))


def _system() -> Iterator[Path]:
    return (path for path in map(Path, _SYSTEM) if path.exists())


def _python(environment: Mapping[str, str]) -> list[Path]:
    """Return the folders of this Python and its packages outside the system's folders."""
    # The first place of `sys.path` is the working directory of the executor.
    named = [sys.prefix, sys.base_prefix, *sys.path[1:], str(Path(__file__).parents[2])]
    for variable in _PATHS:
        named += environment.get(variable, "").split(os.pathsep)
    named = [os.path.abspath(name) for name in named if name]  # noqa: PTH100 - without following links
    homes = {Path.home(), Path("/root"), Path("/home"), Path("/tmp")}  # noqa: S108
    found: list[Path] = []
    for path in sorted({Path(each) for name in named for each in (name, os.path.realpath(name))}):
        is_whole_home = any(home.is_relative_to(path) for home in homes)
        is_there = any(path.is_relative_to(other) for other in (*map(Path, _SYSTEM), *found))
        if path.is_dir() and not is_whole_home and not is_there:
            found.append(path)
    return found

"""Bubblewrap (`bwrap`), which creates sandboxes: check that it works on this machine."""

from __future__ import annotations

import shutil
import subprocess
from typing import Final

PROGRAM: Final = "bwrap"
NAMESPACES: Final = ("--unshare-user", "--unshare-pid", "--unshare-ipc", "--unshare-uts")
INSTALL: Final = "install bubblewrap (`apt-get install bubblewrap`)"
TIMEOUT: Final = 10.0  # [s] for a trial


def trouble() -> str:
    """Return the reason why runs cannot be sandboxed on this machine, and its fix; empty if they can."""
    program = shutil.which(PROGRAM)
    if program is None:
        return f"`{PROGRAM}` is not installed: {INSTALL}"
    trial = [program, *NAMESPACES, "--unshare-net", "--ro-bind", "/", "/", "--proc", "/proc", "--tmpfs", "/tmp"]  # noqa: S108
    try:
        tried = subprocess.run([*trial, "true"], check=False, capture_output=True, text=True, timeout=TIMEOUT)
    except (OSError, subprocess.TimeoutExpired) as error:
        return f"`{PROGRAM}` cannot be started: {error}"
    if tried.returncode == 0:
        return ""
    return (
        f"`{PROGRAM}` cannot create a sandbox: {tried.stderr.strip() or 'unknown error'}; allow user namespaces "
        "(`sysctl user.max_user_namespaces`, AppArmor, or the settings of the container)"
    )

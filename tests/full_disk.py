"""Processes whose files cannot grow beyond a size, as on a full disk."""

from __future__ import annotations

import os
import resource
import subprocess
from collections.abc import Sequence


def run_on_full_disk(command: Sequence[str], size: int) -> subprocess.CompletedProcess[str]:
    """Run a command, each file of which can have at most a number of bytes.

    The command writes no compiled modules: Python 3.11 to 3.13 keep one that was cut off, and each later process
    that imports it fails.

    Args:
        command: Program and arguments.
        size: Largest size of a file [bytes].

    Returns:
        The ended process, with its output as text.
    """
    return subprocess.run(
        command,
        preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (size, size)),
        env={**os.environ, "PYTHONDONTWRITEBYTECODE": "1"},
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )

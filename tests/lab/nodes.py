"""Nodes of labs in separate processes."""

from __future__ import annotations

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from tests.routers import process
from tests.sim_nodes.engines import make_engine


@dataclass(frozen=True)
class Hall:
    """A playing simulator node with two robots: endpoint and process."""

    endpoint: str
    process: subprocess.Popen[bytes]


@contextmanager
def hall_at(folder: Path, name: str = "hall", rate: str | None = "1") -> Iterator[Hall]:
    """Yield a simulator node with its socket in a folder."""
    make_engine("mujoco")
    endpoint = f"unixsock-stream/{folder}/{name}"
    options = () if rate is None else ("--rate", rate)
    command = ("-m", "sim_nodes", "mujoco", "--listen", endpoint, "--world", "hall", "--node", name, *options)
    with process(*command, says=None) as running:
        yield Hall(endpoint, running)

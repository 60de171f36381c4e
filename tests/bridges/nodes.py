"""Nodes that several tests connect to, each at the beginning of a world."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from seoro.bridges.conformance import Make
from seoro.bridges.launch import SimulatorOptions, connect_simulator
from seoro.bridges.models import ModelPath
from tests.routers import process

OPTIONS = SimulatorOptions("empty", 3, ModelPath())
CELL = SimulatorOptions("arm_cell", 3, ModelPath())


Connect = Callable[[SimulatorOptions], Make]
"""Connector to a node, which loads a world."""


@contextmanager
def node(engine: str, folder: Path) -> Iterator[Connect]:
    """Yield a function that connects to a node with a socket in a folder."""
    endpoint = f"unixsock-stream/{folder}/hub"
    with process("-m", "sim_nodes", engine, "--listen", endpoint, "--world", "empty", says=None):
        yield lambda options: lambda: connect_simulator(endpoint, options)


@contextmanager
def running(engine: str, folder: Path, options: SimulatorOptions = OPTIONS) -> Iterator[Make]:
    """Yield a function that connects to a node with a socket in a folder by some options."""
    with node(engine, folder) as connect:
        yield connect(options)

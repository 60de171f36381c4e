"""The engines that tests run with."""

from __future__ import annotations

from importlib.util import find_spec

import pytest

from sim_nodes.__main__ import ENGINES
from sim_nodes.physics import Engine


def make_engine(name: str) -> Engine:
    """An engine by name; a test is skipped where it is not installed."""
    if find_spec(name) is None:
        pytest.skip(f"the engine {name} is not installed")
    return ENGINES[name]()

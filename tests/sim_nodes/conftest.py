from __future__ import annotations

import ctypes
import gc
import sys
from collections.abc import Iterator

import pytest

from tests.sim_nodes.client import Client


@pytest.fixture(autouse=True, scope="module")
def _freed_memory() -> Iterator[None]:
    """Return the memory of engines, which the C library would keep for the process."""
    yield
    gc.collect()
    if sys.platform == "linux":
        ctypes.CDLL(None).malloc_trim(0)


@pytest.fixture
def maze() -> Client:
    return Client("maze")


@pytest.fixture
def empty() -> Client:
    return Client("empty")

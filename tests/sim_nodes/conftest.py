from __future__ import annotations

import pytest

from tests.sim_nodes.client import Client


@pytest.fixture
def maze() -> Client:
    return Client("maze")


@pytest.fixture
def empty() -> Client:
    return Client("empty")

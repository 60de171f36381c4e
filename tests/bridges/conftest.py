from __future__ import annotations

from collections.abc import Iterator

import pytest

from tests.bridges.nodes import Connect, node


@pytest.fixture(scope="session")
def mujoco(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Connect]:
    """Yield a MuJoCo node that all tests share; each client loads a world."""
    pytest.importorskip("mujoco", reason="the engine mujoco is not installed")
    with node("mujoco", tmp_path_factory.mktemp("n")) as connect:
        yield connect

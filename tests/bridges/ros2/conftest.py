"""ROS 2 systems for tests: a router, and nodes behind it."""

from collections.abc import Iterator

import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from tests.routers import process, routing
from tests.sim_nodes.engines import make_engine


@pytest.fixture(scope="session")
def types() -> TypeStore:
    return TypeStore.bundled()


@pytest.fixture
def router() -> Iterator[str]:
    """Yield the endpoint of a router."""
    with routing() as endpoint:
        yield endpoint


@pytest.fixture(scope="session")
def simulator(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """Yield the endpoint of a simulator node; each test loads a world."""
    make_engine("mujoco")
    endpoint = f"unixsock-stream/{tmp_path_factory.mktemp('simulator')}/sim"
    command = ("-m", "sim_nodes", "mujoco", "--node", "sim", "--listen", endpoint, "--world", "empty")
    with process(*command, says=None):
        yield endpoint

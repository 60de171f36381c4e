"""Systems of ROS 2 for tests: a router, and what is behind it."""

import socket
import subprocess
import sys
from collections.abc import AsyncIterator, Iterator

import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.session import open_session
from tests.sim_nodes.engines import make_engine


@pytest.fixture(scope="session")
def types() -> TypeStore:
    return TypeStore.bundled()


@pytest.fixture
async def router() -> AsyncIterator[str]:
    """The endpoint of a router, such as rmw_zenohd is one."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        port = probe.getsockname()[1]
    endpoint = f"tcp/127.0.0.1:{port}"
    async with open_session(listen=endpoint):
        yield endpoint


@pytest.fixture(scope="session")
def simulator(tmp_path_factory: pytest.TempPathFactory) -> Iterator[str]:
    """The endpoint of a simulator node, in which each test loads a world."""
    make_engine("mujoco")
    endpoint = f"unixsock-stream/{tmp_path_factory.mktemp('simulator')}/sim"
    command = [sys.executable, "-m", "sim_nodes", "mujoco", "--node", "sim", "--listen", endpoint]
    with subprocess.Popen([*command, "--world", "empty"], stdout=subprocess.PIPE) as process:
        try:
            assert process.stdout is not None
            process.stdout.readline()
            yield endpoint
        finally:
            process.kill()

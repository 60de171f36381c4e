"""Systems of ROS 2 for tests: a router, and what is behind it."""

import socket
from collections.abc import AsyncIterator

import pytest

from seoro.bridges.ros2.interfaces import TypeStore
from seoro.bridges.session import open_session


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

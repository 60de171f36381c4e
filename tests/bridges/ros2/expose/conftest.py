from __future__ import annotations

import subprocess
import sys
from collections.abc import Iterator

import pytest

from tests.sim_nodes.engines import make_engine


@pytest.fixture(scope="package")
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

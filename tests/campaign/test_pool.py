"""Slots of the pool whose simulator does not start."""

from collections import deque
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import cast

import pytest

from seoro.campaign.engine import NotBegun
from seoro.campaign.pool import pool
from seoro.campaign.pool.simulators import Node
from seoro.campaign.store.folder import read_campaign
from seoro.concurrency.forks.using import Forks
from seoro.errors import BackendError
from tests.campaign.generated import generate


async def test_a_simulator_that_started_before_is_started_again(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    works = iter([False, True, False, False, True, False, False, False])

    @asynccontextmanager
    async def node(_name: str) -> AsyncIterator[Node]:
        if not next(works):
            raise BackendError("no memory")
        yield Node("", 1, deque())

    monkeypatch.setattr(pool, "simulator_node", node)
    generate(tmp_path, 0)
    slot = pool._Slot(read_campaign(tmp_path), tmp_path, cast(Forks, None), "w")
    with pytest.raises(BackendError):  # for the first time
        await slot._start_simulator("mujoco")
    await slot._start_simulator("mujoco")
    slot._count = 1
    for expected in (NotBegun, NotBegun, None, NotBegun, NotBegun, BackendError):
        if expected is None:
            await slot._start_simulator("mujoco")
        else:
            with pytest.raises(expected, match="no memory"):
                await slot._start_simulator("mujoco")

"""Campaigns of tests start without loading modules anew."""

from __future__ import annotations

import asyncio
import os
from collections.abc import Iterator
from typing import Any

import pytest

from tests.campaign.warm import MODULE, Warm


@pytest.fixture(scope="session")
def _warm() -> Iterator[Warm]:
    warm = Warm()
    yield warm
    warm.close()


@pytest.fixture
def is_started_anew() -> bool:
    """Return whether fork servers are processes of their own; modules with tests about these replace it."""
    return False


@pytest.fixture(autouse=True)
def _warm_start(is_started_anew: bool, request: pytest.FixtureRequest, monkeypatch: pytest.MonkeyPatch) -> None:
    """Fork the fork servers of campaigns that this process runs, instead of starting them."""
    if is_started_anew:
        return
    start = asyncio.create_subprocess_exec

    async def fork(*command: str, **options: Any) -> Any:
        if command[1:3] != ("-m", MODULE):
            return await start(*command, **options)
        warm: Warm = request.getfixturevalue("_warm")
        return warm.fork(command[3:], options["pass_fds"], options["env"] or os.environ)

    monkeypatch.setattr(asyncio, "create_subprocess_exec", fork)

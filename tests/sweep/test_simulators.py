"""Simulators that runs of a sweep share."""

from __future__ import annotations

from collections.abc import Sequence
from importlib.util import find_spec
from pathlib import Path

import anyio
import pytest

from seoro.sweep.processes import simulator_for


def arguments_for(arguments: Sequence[str]) -> tuple[Sequence[str], bool]:
    """Return the arguments of runs, and whether the socket exists meanwhile; afterwards it is removed."""

    async def look() -> tuple[Sequence[str], bool]:
        async with simulator_for(arguments) as given:
            return given, any(socket_of(each).exists() for each in given)

    given, exists = anyio.run(look)
    assert not any(socket_of(each).exists() for each in given)
    return given, exists


def socket_of(argument: str) -> Path:
    return Path(argument.removeprefix("--connect=unixsock-stream/"))


def test_runs_share_a_simulator_that_ends_after_them() -> None:
    if find_spec("mujoco") is None:
        pytest.skip("the engine mujoco is not installed")
    given, exists = arguments_for(["a.osc", "--sim=mujoco", "--rate=max"])
    assert given[0] == "a.osc" and given[2] == "--rate=max"
    assert given[1].startswith("--connect=unixsock-stream/")
    assert exists


@pytest.mark.parametrize("arguments", [["a.osc", "--sim=gazebo"], ["a.osc"], ["a.osc", "--connect=tcp/[::1]:1"]])
def test_runs_without_a_shared_simulator_keep_their_arguments(arguments: list[str]) -> None:
    given, exists = arguments_for(arguments)
    assert given == arguments
    assert not exists

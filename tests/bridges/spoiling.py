"""Backends with a fault: methods of a simulator node are replaced, so that it breaks a rule."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager
from typing import ParamSpec

import pytest

from seoro.bridges.conformance import Make, SimulatedBackend, check_rule
from seoro.bridges.sim.node import SimulatorNode

P = ParamSpec("P")
Spoil = Callable[[SimulatorNode], None]


def replace_method(node: SimulatorNode, **methods: Callable[..., Awaitable[object]]) -> None:
    """Replace methods of a node by others."""
    vars(node).update(methods)


async def do_nothing(*arguments: object) -> None:
    """Do nothing, and say nothing of it."""


def spoiled(make: Make, spoil: Spoil) -> Make:
    """What opens a backend, and spoils it."""

    @asynccontextmanager
    async def opened() -> AsyncIterator[SimulatedBackend]:
        async with make() as backend:
            assert isinstance(backend, SimulatorNode)
            spoil(backend)
            yield backend

    return opened


async def expect_broken(rule: Callable[P, Awaitable[None]], words: str, *of: P.args, **named: P.kwargs) -> None:
    """Expect a rule to be broken, and the message to say so, with some words."""
    with pytest.raises(AssertionError) as broken:
        await check_rule(rule, *of, **named)
    message = str(broken.value)
    assert message.startswith(str(rule.__doc__).partition("\n")[0])
    assert words in message

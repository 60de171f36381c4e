"""Simulator nodes with replaced methods that break a rule."""

from __future__ import annotations

from collections.abc import AsyncIterator, Awaitable, Callable
from contextlib import asynccontextmanager

import pytest

from seoro.bridges.conformance import ArmFacts, Make, Rule, SimulatedBackend, check_rule
from seoro.bridges.sim.node import SimulatorNode

Spoil = Callable[[SimulatorNode], None]


def replace_method(node: SimulatorNode, **methods: Callable[..., Awaitable[object]]) -> None:
    """Replace methods of a node by others."""
    vars(node).update(methods)


async def do_nothing(*arguments: object) -> None:
    """Do nothing."""


def spoiled(make: Make, spoil: Spoil) -> Make:
    """Return a function that opens a backend, and spoils it."""

    @asynccontextmanager
    async def opened() -> AsyncIterator[SimulatedBackend]:
        async with make() as backend:
            assert isinstance(backend, SimulatorNode)
            spoil(backend)
            yield backend

    return opened


async def expect_broken(rule: Rule, words: str, make: Make, facts: ArmFacts | None = None) -> None:
    """Expect a broken rule, and a message with the rule and some words."""
    with pytest.raises(AssertionError) as broken:
        await check_rule(rule, make, facts)
    message = str(broken.value)
    assert message.startswith(str(rule.__doc__).partition("\n")[0])
    assert words in message

"""Engines for tests."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from importlib.util import find_spec
from typing import Any

import pytest

from sim_nodes.__main__ import ENGINES
from sim_nodes.check import check_rule
from sim_nodes.physics import IDENTITY, Engine, Scene
from sim_nodes.views import Lens, NoRendering, View


def _pybullet(mark: pytest.MarkDecorator) -> tuple[Any, ...]:
    return tuple(name if name == "mujoco" else pytest.param(name, marks=mark) for name in ENGINES)


PYBULLET_IN_MORE = _pybullet(pytest.mark.more)
"""Engines of tests of what both share; rules for engines, which are checked in both, find differences sooner."""
MUJOCO_FIRST = _pybullet(pytest.mark.slow)
"""Engines of long tests: PyBullet in `make test-all` only."""


def make_engine(name: str) -> Engine:
    """Make an engine by name; skip the test if it is not installed."""
    if find_spec(name) is None:
        pytest.skip(f"the engine {name} is not installed")
    return ENGINES[name]()


def expect_broken(rule: Callable[[Callable[[], Engine]], None], make: Callable[[], Engine], words: str) -> None:
    """Expect an engine to break a rule, with some words in the message."""
    with pytest.raises(AssertionError) as broken:
        check_rule(rule, make)
    message = str(broken.value)
    assert message.startswith((rule.__doc__ or "").partition("\n")[0])
    assert words in message


def needs_pictures(name: str) -> None:
    """Skip a test if an engine is not installed, or cannot render."""
    make_engine(name)
    reason = _why_blind(name)
    if reason is not None:
        pytest.skip(f"the engine {name} does not render here: {reason}")


@cache
def _why_blind(name: str) -> str | None:
    engine = make_engine(name)
    engine.build(Scene((), (), (-1.0, -1.0, 1.0, 1.0)))
    try:
        engine.render(View((0.0, 0.0, 1.0), IDENTITY, Lens(width=16, height=16)))
    except NoRendering as error:
        return str(error)
    return None

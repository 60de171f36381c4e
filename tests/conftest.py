"""Fixtures and settings of all tests."""

from __future__ import annotations

import gc
from collections.abc import Iterator
from importlib.util import find_spec

import pytest

# Before anything draws: Mesa draws with LLVM, which may bring another z3, and one that is loaded after that takes
# functions of the other. Nodes draw in processes of their own, tests in that in which they solve constraints.
import z3  # noqa: F401
from hypothesis import HealthCheck, settings

# The duration of an example depends on the load of the machine.
settings.register_profile("seoro", deadline=None, suppress_health_check=[HealthCheck.too_slow])
settings.load_profile("seoro")


@pytest.fixture(autouse=True, scope="session")
def _cache_of_the_tests(tmp_path_factory: pytest.TempPathFactory) -> Iterator[None]:
    """Nothing is read from or written to the cache of the user."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("XDG_CACHE_HOME", str(tmp_path_factory.mktemp("cache")))
        yield


@pytest.fixture(autouse=True, scope="session")
def _no_warnings_of_a_busy_machine() -> Iterator[None]:
    """Steps of actions may take as long as they do on a machine that others keep busy."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("seoro.runtime.execution.blocking.LIMIT", 30.0)
        yield


def pytest_collection_finish() -> None:
    """Keep the collector from going through what thousands of tests consist of, again and again."""
    gc.collect()
    gc.freeze()


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Skip tests of engines that are not installed."""
    for mark in item.iter_markers("engine"):
        if find_spec(mark.args[0]) is None:
            pytest.skip(f"the engine {mark.args[0]} is not installed")

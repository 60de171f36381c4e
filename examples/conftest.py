"""Marks of examples that take long."""

from pathlib import Path

import pytest

FOLDER = Path(__file__).parent


@pytest.hookimpl(tryfirst=True)  # before `-m` selects
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Leave scenarios in PyBullet to `make test-more`."""
    for item in items:
        if item.path.is_relative_to(FOLDER) and item.name.endswith("[pybullet]"):
            item.add_marker(pytest.mark.more)

"""Scenarios of this folder with cameras need pictures; they are skipped where there are none."""

import pytest


@pytest.fixture(autouse=True)
def _pictures(request: pytest.FixtureRequest) -> None:
    if "cameras" in request.node.name:
        request.getfixturevalue("draws")

"""Skip scenarios with cameras in this folder where images cannot be rendered."""

import pytest


@pytest.fixture(autouse=True)
def _pictures(request: pytest.FixtureRequest) -> None:
    if "cameras" in request.node.name:
        request.getfixturevalue("draws")

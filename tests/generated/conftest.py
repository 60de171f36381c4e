"""Fixtures of all tests with generated programs."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest

from seoro.runtime.execution import blocking


@pytest.fixture(autouse=True, scope="package")
def _no_word_of_blocking() -> Iterator[None]:
    """On a busy machine, a delay of a tenth of a second would add a record to the trace, which is compared."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocking, "LIMIT", math.inf)
        yield

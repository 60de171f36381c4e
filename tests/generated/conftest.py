"""What all tests of made-up programs have in common."""

from __future__ import annotations

import math
from collections.abc import Iterator

import pytest

from seoro.runtime import blocking


@pytest.fixture(autouse=True, scope="package")
def _no_word_of_blocking() -> Iterator[None]:
    """A machine that holds a process up for a tenth of a second has it say so in the trace, which is compared."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(blocking, "LIMIT", math.inf)
        yield

"""Samples of long lists of parameters, for `make test`; `make test-more` has all."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import pytest


def sampled(values: Sequence[Any], every: int) -> list[Any]:
    """Mark all values but each n-th one, the first included, as `more`."""
    return [
        value if number % every == 0 else pytest.param(value, marks=pytest.mark.more)
        for number, value in enumerate(values)
    ]

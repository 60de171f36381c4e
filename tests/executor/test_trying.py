"""Dry runs: one at a time."""

from typing import Any, cast

import pytest

from seoro.bridges.executor import messages as wire
from seoro.bridges.wire.refusal import RequestRefused
from seoro.executor.trying import DryRuns


def test_a_second_one_is_to_be_asked_for_later() -> None:
    dry_runs = DryRuns(cast("Any", None))
    with dry_runs.one(), pytest.raises(RequestRefused) as refused, dry_runs.one():
        pass
    assert refused.value.code == wire.UNAVAILABLE
    with dry_runs.one():
        pass

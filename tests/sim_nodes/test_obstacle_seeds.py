from __future__ import annotations

import pytest

from seoro.bridges.wire import Outcome
from tests.sim_nodes.client import obstacle_run


def check(seed: int) -> None:
    client, ended, contacts = obstacle_run(seed)
    assert (ended.outcome, contacts) == (Outcome.SUCCEEDED, [])
    assert ended.time < 60.0
    assert client.truth.distance(3.0, -3.0) < 0.15


@pytest.mark.parametrize("seed", range(3))
def test_a_box_in_the_way_is_driven_around(seed: int) -> None:
    check(seed)


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(3, 20))
def test_a_box_in_the_way_is_driven_around_with_more_seeds(seed: int) -> None:
    check(seed)

from __future__ import annotations

import pytest

from seoro.bridges.wire import Outcome
from sim_nodes.__main__ import ENGINES
from tests.sim_nodes.client import obstacle_run
from tests.sim_nodes.engines import MUJOCO_FIRST


def check(engine: str, seed: int) -> None:
    client, ended, contacts = obstacle_run(seed, engine)
    assert (ended.outcome, contacts) == (Outcome.SUCCEEDED, [])
    assert ended.time < 60.0
    assert client.truth.distance(3.0, -3.0) < 0.15


@pytest.mark.more
@pytest.mark.parametrize("engine", MUJOCO_FIRST)
@pytest.mark.parametrize("seed", range(1))
def test_a_robot_drives_around_a_box(engine: str, seed: int) -> None:
    check(engine, seed)


@pytest.mark.slow
@pytest.mark.parametrize("engine", ENGINES)
@pytest.mark.parametrize("seed", range(1, 20))
def test_a_robot_drives_around_a_box_with_more_seeds(engine: str, seed: int) -> None:
    check(engine, seed)

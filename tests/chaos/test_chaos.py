"""Some rounds of the chaos test; `make chaos` plays more."""

from pathlib import Path

import pytest

from tests.chaos.oracle import violations
from tests.chaos.plan import draw
from tests.chaos.play import play
from tests.chaos.stage import staged


@pytest.mark.slow
@pytest.mark.engine("mujoco")
def test_guarantees_hold_under_random_faults(tmp_path: Path) -> None:
    with staged(tmp_path) as stage:
        found = {seed: violations(play(draw(seed), stage, tmp_path / f"round_{seed}")) for seed in range(4)}
    assert found == {seed: [] for seed in range(4)}

from __future__ import annotations

import pytest

from sim_nodes.check.bench import CUBE, ORIGIN, at, body, built
from sim_nodes.mujoco.engine import MujocoEngine
from sim_nodes.physics import BodyState, UnstablePhysics


def test_lost_physics_are_said_with_the_warning_of_mujoco(caplog: pytest.LogCaptureFixture) -> None:
    engine = built(MujocoEngine, ORIGIN)
    engine.add_body("thing", body(CUBE), at(1.0, 1.0, 1.0))
    engine.set_body_state("thing", BodyState((1.0, 1.0, 1.0), linear=(1e300, 0.0, 0.0), angular=(1e300, 0.0, 0.0)))
    with pytest.raises(UnstablePhysics, match="reset the simulation"):
        engine.step()
    assert "Nan, Inf or huge value" in caplog.text

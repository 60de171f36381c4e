"""Fixtures for scenarios of several folders."""

import pytest

from sim_nodes.check.bench import built
from sim_nodes.physics import IDENTITY
from sim_nodes.views import Lens, NoRendering, View


@pytest.fixture(scope="session")
def draws() -> None:
    """Skip the test if MuJoCo cannot render images here."""
    engine = pytest.importorskip("sim_nodes.mujoco.engine", reason="the engine mujoco is not installed")
    try:
        built(engine.MujocoEngine).render(View((0.0, 0.0, 1.0), IDENTITY, Lens(width=16, height=16)))
    except NoRendering as error:
        pytest.skip(str(error))

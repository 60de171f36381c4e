"""The scenarios of this folder are tests with a simulator of their own, unless another is named."""

import pytest

import seoro
from seoro.embed import OptionFields
from sim_nodes.check.bench import built
from sim_nodes.physics import IDENTITY
from sim_nodes.views import Lens, NoRendering, View


@pytest.fixture(scope="session")
def _draws() -> None:
    """Skip what needs pictures of MuJoCo where there are none."""
    engine = pytest.importorskip("sim_nodes.mujoco.engine", reason="the engine mujoco is not installed")
    try:
        built(engine.MujocoEngine).render(View((0.0, 0.0, 1.0), IDENTITY, Lens(width=16, height=16)))
    except NoRendering as error:
        pytest.skip(str(error))


@pytest.fixture
def osc_options(osc_options: OptionFields, _draws: None) -> OptionFields:
    """In MuJoCo's empty world, as fast as it goes."""
    simulator = osc_options.get("simulator") or seoro.Simulator(name="mujoco", world="empty")
    return {**osc_options, "simulator": simulator}

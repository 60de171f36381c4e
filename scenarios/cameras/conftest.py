"""The scenarios of this folder are tests with a simulator of their own, unless another is named."""

import pytest

import seoro
from seoro.embed.options import OptionFields


@pytest.fixture
def osc_options(osc_options: OptionFields, draws: None) -> OptionFields:
    """In MuJoCo's empty world, as fast as it goes."""
    simulator = osc_options.get("simulator") or seoro.Simulator(name="mujoco", world="empty")
    return {**osc_options, "simulator": simulator}

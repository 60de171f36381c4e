"""Fixtures and marks for scenarios of several folders."""

from pathlib import Path

import pytest

from sim_nodes.check.bench import built
from sim_nodes.physics import IDENTITY
from sim_nodes.views import Lens, NoRendering, View

FOLDER = Path(__file__).parent
QUICK_IN_BOTH = ("bump", "obstacle")  # the suite has these in PyBullet, too


@pytest.hookimpl(tryfirst=True)  # before `-m` selects
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark scenarios in PyBullet as slow: conformance rules of engines find differences sooner."""
    for item in items:
        in_pybullet = item.path.is_relative_to(FOLDER) and item.name.endswith("[pybullet]")
        if in_pybullet and item.path.stem not in QUICK_IN_BOTH:
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def draws() -> None:
    """Skip the test if MuJoCo cannot render images here."""
    engine = pytest.importorskip("sim_nodes.mujoco.engine", reason="the engine mujoco is not installed")
    try:
        built(engine.MujocoEngine).render(View((0.0, 0.0, 1.0), IDENTITY, Lens(width=16, height=16)))
    except NoRendering as error:
        pytest.skip(str(error))

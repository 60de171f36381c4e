"""Fixtures and marks for scenarios of several folders."""

from pathlib import Path

import pytest

from sim_nodes.check.bench import built
from sim_nodes.physics import IDENTITY
from sim_nodes.views import Lens, NoRendering, View

FOLDER = Path(__file__).parent
QUICK_IN_BOTH = "bump"  # `make test` has it in PyBullet, too
MORE = ("docking", "faulty_cameras", "faulty_lidar", "spotting")
MORE_IN_PYBULLET = ("obstacle", *(path.stem for path in (FOLDER / "cookbook").glob("*.osc")))


@pytest.hookimpl(tryfirst=True)  # before `-m` selects
def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark scenarios that take long: rules for engines and tests of sensors find differences sooner."""
    for item in items:
        if not item.path.is_relative_to(FOLDER):
            continue
        in_pybullet = item.name.endswith("[pybullet]")
        if item.path.stem in MORE or (in_pybullet and item.path.stem in MORE_IN_PYBULLET):
            item.add_marker(pytest.mark.more)
        elif in_pybullet and item.path.stem != QUICK_IN_BOTH:
            item.add_marker(pytest.mark.slow)


@pytest.fixture(scope="session")
def draws() -> None:
    """Skip the test if MuJoCo cannot render images here."""
    engine = pytest.importorskip("sim_nodes.mujoco.engine", reason="the engine mujoco is not installed")
    try:
        built(engine.MujocoEngine).render(View((0.0, 0.0, 1.0), IDENTITY, Lens(width=16, height=16)))
    except NoRendering as error:
        pytest.skip(str(error))

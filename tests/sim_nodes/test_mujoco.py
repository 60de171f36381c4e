from __future__ import annotations

import os
import subprocess
import sys

import pytest

from sim_nodes.check.bench import CUBE, ORIGIN, at, body, built
from sim_nodes.physics import IDENTITY, BodyState, UnstablePhysics
from sim_nodes.views import Lens, NoRendering, View

pytest.importorskip("mujoco", reason="the engine mujoco is not installed")

from sim_nodes.mujoco import camera
from sim_nodes.mujoco.engine import MujocoEngine


def test_diverged_physics_raises_with_the_warning_of_mujoco(caplog: pytest.LogCaptureFixture) -> None:
    engine = built(MujocoEngine, ORIGIN)
    engine.add_body("thing", body(CUBE), at(1.0, 1.0, 1.0))
    engine.set_body_state("thing", BodyState((1.0, 1.0, 1.0), linear=(1e300, 0.0, 0.0), angular=(1e300, 0.0, 0.0)))
    with pytest.raises(UnstablePhysics, match="reset the simulation"):
        engine.step()
    assert "Nan, Inf or huge value" in caplog.text


def test_missing_rendering_libraries_are_reported(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(camera, "_gl_context", camera._gl_context.__wrapped__)  # not that of other tests
    monkeypatch.setattr(camera, "_has_egl_devices", lambda: False)
    monkeypatch.setitem(sys.modules, "mujoco.osmesa", None)  # as where its library is missing
    monkeypatch.delenv("MUJOCO_GL", raising=False)
    engine = built(MujocoEngine, ORIGIN)
    with pytest.raises(NoRendering, match="apt-get install libegl1 libegl-mesa0 libgl1-mesa-dri, or libosmesa6"):
        engine.render(View((0.0, 0.0, 1.0), IDENTITY, Lens()))


def test_an_environment_variable_selects_the_backend_of_mujoco(monkeypatch: pytest.MonkeyPatch) -> None:
    for has_egl in (True, False):
        monkeypatch.setattr(camera, "_has_egl_devices", lambda found=has_egl: found)
        for chosen, wanted in (("egl", "egl"), ("OSMesa", "osmesa"), ("glfw", "egl" if has_egl else "osmesa")):
            monkeypatch.setenv("MUJOCO_GL", chosen)
            assert camera._backend() == wanted


def test_a_simulation_runs_without_rendering_libraries() -> None:
    code = "import os, sim_nodes.mujoco.engine; print(os.environ['MUJOCO_GL'])"
    environment = {**os.environ, "MUJOCO_GL": "nonsense"}  # prevents the import of mujoco
    command = [sys.executable, "-c", code]
    done = subprocess.run(command, env=environment, capture_output=True, text=True, timeout=60, check=False)
    assert (done.stdout.strip(), done.stderr) == ("nonsense", "")

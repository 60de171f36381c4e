from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from sim_nodes.check.bench import CUBE, ORIGIN, OTHER, ROBOT, at, body, built, scene, steps
from sim_nodes.geometry import Array, Pose2
from sim_nodes.physics import IDENTITY, BodyState, UnstablePhysics
from sim_nodes.views import Lens, NoRendering, View

pytest.importorskip("mujoco", reason="the engine mujoco is not installed")

from sim_nodes.mujoco import camera
from sim_nodes.mujoco.engine import MujocoEngine
from sim_nodes.mujoco.joint_values import JointValues
from sim_nodes.mujoco.rays import Cast, Rays


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


@pytest.mark.parametrize("rise", [0.0, -0.15])
def test_hidden_bodies_change_no_distance(rise: float, monkeypatch: pytest.MonkeyPatch) -> None:
    engine = MujocoEngine()
    engine.build(scene(ORIGIN, Pose2(1.5, 0.2, 1.0)))
    engine.add_bodies([(f"cube{z}", body(CUBE), at(-1.0, z, z)) for z in (0.1, 0.5, 1.2)])
    engine.set_body_state(ROBOT, BodyState((0.0, 0.0, 0.05), (0.998, 0.03, 0.05, 0.0)))  # leans
    bearings = np.linspace(-np.pi, np.pi, 200)
    beams = np.column_stack([np.cos(bearings), np.sin(bearings), np.full(200, rise)])
    model = engine._model
    before = [array.copy() for array in (model.geom_group, model.body_geomnum, model.body_bvhadr)]
    hidden: list[float] = []  # shares of the shapes that rays see
    reachable = Rays._reachable
    monkeypatch.setattr(Rays, "_without_hidden", _recorded(Rays._without_hidden, hidden))
    fast = [
        engine.cast_rays(name, "rplidar_link", beams, limit) for name in (ROBOT, OTHER) for limit in (0.9, 9.0)
    ]
    assert max(hidden) > 0.5
    monkeypatch.setattr(Rays, "_reachable", _unlimited(reachable))
    slow = [
        engine.cast_rays(name, "rplidar_link", beams, limit) for name in (ROBOT, OTHER) for limit in (0.9, 9.0)
    ]
    np.testing.assert_array_equal(fast, slow)
    assert np.isfinite(fast).any()
    for array, present in zip(before, (model.geom_group, model.body_geomnum, model.body_bvhadr), strict=True):
        np.testing.assert_array_equal(array, present)


def _recorded(
    hide: Callable[[Rays, NDArray[np.bool_]], Any], hidden: list[float]
) -> Callable[[Rays, NDArray[np.bool_]], Any]:
    def recording(rays: Rays, reachable: NDArray[np.bool_]) -> Any:
        hidden.append(float((~reachable).mean()))
        return hide(rays, reachable)

    return recording


def _unlimited(reachable: Callable[..., NDArray[np.bool_]]) -> Callable[..., NDArray[np.bool_]]:
    """Return a `_reachable` of rays without a limit, in all directions."""

    def everywhere(rays: Rays, casts: Sequence[Cast], origins: Array, *_: object) -> NDArray[np.bool_]:
        count = len(casts)
        return reachable(rays, casts, origins, np.full(count, np.inf), [np.zeros((3, 3))] * count)

    return everywhere


def test_states_are_read_once_in_a_step() -> None:
    engine = built(MujocoEngine, ORIGIN)
    first = engine.body_state(ROBOT)
    assert engine.body_state(ROBOT) is first
    engine.step()
    assert engine.body_state(ROBOT) != first
    engine.set_body_state(ROBOT, at(1.0, 0.0, 0.1))
    assert engine.body_state(ROBOT) == at(1.0, 0.0, 0.1)


def test_values_of_all_joints_are_converted_once_in_a_step(monkeypatch: pytest.MonkeyPatch) -> None:
    engine = built(MujocoEngine, ORIGIN, Pose2(2.0, 0.0, 0.0))
    assert isinstance(engine, MujocoEngine)
    made: list[JointValues] = []

    def recorded(data: Any) -> JointValues:
        made.append(JointValues(data))
        return made[-1]

    monkeypatch.setattr("sim_nodes.mujoco.bodies.JointValues", recorded)
    for robot in (ROBOT, OTHER):
        engine.command_wheels(robot, 5.0, 5.0)
    engine.step()
    before = [engine.wheel_angles(robot) for robot in (ROBOT, OTHER)]
    assert len(made) == 1
    engine.step()
    assert all(engine.wheel_angles(robot) > angles for robot, angles in zip((ROBOT, OTHER), before, strict=True))


def test_work_has_the_same_bits_however_often_it_is_read() -> None:
    totals = []
    for every in (1, 7, 120):
        engine = built(MujocoEngine, ORIGIN, Pose2(2.0, 0.0, 0.0))
        assert isinstance(engine, MujocoEngine)
        engine.command_wheels(OTHER, 5.0, 3.0)
        for step in range(1, 121):
            steps(engine, 1)
            if step % every == 0:
                work = [engine.motor_work(robot) for robot in (ROBOT, OTHER)]
        totals.append([engine.motor_work(robot) for robot in (ROBOT, OTHER)])
        engine.add_body("cube", body(CUBE), at(5.0, 5.0, 0.1))
        assert [engine.motor_work(robot) for robot in (ROBOT, OTHER)] == totals[-1]
    assert totals[0] == totals[1] == totals[2] == work
    assert totals[0][0] < 1e-3 < 0.1 < totals[0][1]

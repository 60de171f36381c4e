"""Different engines agree on the same world."""

from __future__ import annotations

import math
from functools import partial

import numpy as np
import pytest

from sim_nodes.check.bench import ORIGIN, ROBOT, TURTLEBOT, built, drive, run
from sim_nodes.check.bodies import LOPSIDED
from sim_nodes.check.sensing import DIRECTIONS, LIMIT
from sim_nodes.geometry import Array, Pose2, quaternion, rotation_matrix
from sim_nodes.inertia import inertia
from sim_nodes.physics import BodyState, Engine, PlacedRobot
from sim_nodes.worlds.loader import load_world
from tests.sim_nodes.engines import make_engine

pytest.importorskip("mujoco", reason="the engine mujoco is not installed")

import mujoco

from sim_nodes.mujoco.model import add_body, robot_spec

DIRECT = 2  # pybullet.DIRECT
LINKS = ("base_link", "left_wheel", "right_wheel", "front_caster", "rplidar_link")
PLACES = (ORIGIN, Pose2(3.0, -3.0, 1.0), Pose2(-4.5, 4.5, -2.0))


@pytest.fixture
def engines() -> tuple[Engine, Engine]:
    first, second = (built(partial(make_engine, name), ORIGIN) for name in ("mujoco", "pybullet"))
    return first, second


@pytest.mark.parametrize(("linear", "angular"), [(0.3, 0.0), (0.3, 0.3), (0.0, 1.0), (-0.2, 0.0)])
def test_drives_end_at_the_same_pose(engines: tuple[Engine, Engine], linear: float, angular: float) -> None:
    ends = []
    for engine in engines:
        drive(engine, linear, angular)
        run(engine, 3.0 / max(abs(linear), abs(angular)))
        ends.append(engine.body_state(ROBOT).planar)
    way = abs(linear) * 3.0 / max(abs(linear), abs(angular))
    assert ends[0].distance(ends[1].x, ends[1].y) < 0.02 * way + 0.01
    assert math.remainder(ends[0].yaw - ends[1].yaw, math.tau) == pytest.approx(0.0, abs=0.1)


def test_lidars_measure_the_same_ranges_in_the_maze(engines: tuple[Engine, Engine]) -> None:
    scans: list[list[Array]] = []
    for engine in engines:
        engine.build(load_world("maze").scene)
        scans.append([])
        for place in PLACES:
            state = BodyState((place.x, place.y, 0.0), quaternion(0.0, 0.0, place.yaw))
            engine.set_body_state("turtlebot4", state)
            scans[-1].append(engine.cast_rays("turtlebot4", "rplidar_link", DIRECTIONS, LIMIT))
    np.testing.assert_allclose(scans[0], scans[1], atol=0.01)


def test_links_of_robots_have_the_same_mass_and_inertia() -> None:
    pytest.importorskip("pybullet", reason="the engine pybullet is not installed")
    from pybullet_utils.bullet_client import BulletClient

    from sim_nodes.pybullet import captured_output
    from sim_nodes.pybullet.model import load_robot
    from sim_nodes.pybullet.textures import Textures

    with captured_output():
        bullet = BulletClient(DIRECT)
    number, found = load_robot(bullet, PlacedRobot(ROBOT, TURTLEBOT, ORIGIN), Textures(bullet))
    model = robot_spec(TURTLEBOT).compile()
    masses = {link: bullet.getDynamicsInfo(number, index)[0] for link, index in found.links.items()}
    assert masses == {link: pytest.approx(model.body(link).mass[0]) for link in LINKS}
    for link, index in found.links.items():
        moments = bullet.getDynamicsInfo(number, index)[2]
        assert sorted(moments) == pytest.approx(sorted(model.body(link).inertia)), link


def test_inertias_of_bodies_match_those_of_mujoco() -> None:
    spec = mujoco.MjSpec()
    add_body(spec, "body", LOPSIDED, BodyState((0.0, 0.0, 1.0)))
    wanted = spec.compile().body("body")
    found = inertia(LOPSIDED)
    assert found.centre == pytest.approx(wanted.ipos)
    assert sorted(found.moments) == pytest.approx(sorted(wanted.inertia))
    tensors = [turn @ np.diag(moments) @ turn.T for turn, moments in (
        (rotation_matrix(found.axes), found.moments),
        (rotation_matrix(tuple(wanted.iquat)), wanted.inertia),
    )]  # fmt: skip
    np.testing.assert_allclose(tensors[0], tensors[1], atol=1e-9)

"""Refused robots and props: outside of the world, in one another, with an impossible inertia or pose."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import pytest

from seoro.bridges.wire import LabResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.models import parse_model
from sim_nodes.worlds.loader import WorldError, load_world
from tests.sim_nodes.client import Client

WORLD = """name: w
extent: [-3, -3, 3, 3]
robots:
  - {name: one, robot: turtlebot4, pose: {x: 1.0}}
  - {name: other, robot: ROBOT, pose: {POSE}}
"""


def world(folder: Path, pose: str, robot: str = "turtlebot4") -> str:
    path = folder / "w.yaml"
    path.write_text(WORLD.replace("ROBOT", robot).replace("POSE", pose))
    return str(path)


@pytest.mark.parametrize(
    ("pose", "robot", "words"),
    [
        (
            "x: 9.0, y: 9.0",
            "turtlebot4",
            "'other' at x 9 m, y 9 m is outside of the world; expected x from",
        ),
        ("x: -3.1", "ur10e", "outside of the world"),
        ("x: 1.0", "turtlebot4", "'other' is 0.000 m from 'one'; expected 0.3"),
        ("x: 1.2, y: 0.1", "turtlebot4", "so that they do not overlap"),
        ("x: 1.1", "ur10e", "so that they do not overlap"),
    ],
)
def test_robots_outside_of_the_world_or_overlapping_are_refused(
    tmp_path: Path, pose: str, robot: str, words: str
) -> None:
    path = world(tmp_path, pose, robot)
    with pytest.raises(WorldError, match=words) as caught:
        load_world(path)
    assert str(caught.value).startswith(f"{path}:5: robots.1.pose: ")


@pytest.mark.parametrize(("pose", "robot"), [("x: 1.4", "turtlebot4"), ("x: 1.0, z: 0.8", "ur10e")])
def test_robots_beside_and_above_one_another_are_accepted(tmp_path: Path, pose: str, robot: str) -> None:
    assert len(load_world(world(tmp_path, pose, robot)).robots) == 2


URDF = """<robot name="a"><link name="b"><inertial><mass value="1"/><inertia {}/></inertial>
<collision><geometry><box size="0.2 0.2 0.2"/></geometry></collision></link></robot>"""
SDF = """<sdf version="1.9"><model name="a"><link name="b"><inertial><mass>1</mass><inertia>{}</inertia></inertial>
<collision name="c"><geometry><box><size>0.2 0.2 0.2</size></box></geometry></collision></link></model></sdf>"""
MJCF = """<mujoco><worldbody><body name="a"><freejoint/><inertial pos="0 0 0" mass="1" diaginertia="{}"/>
<geom type="box" size="0.1 0.1 0.1"/></body></worldbody></mujoco>"""


def in_urdf(x: float, y: float, z: float) -> str:
    return URDF.format(f'ixx="{x}" iyy="{y}" izz="{z}" ixy="0" ixz="0" iyz="0"')


def in_sdf(x: float, y: float, z: float) -> str:
    return SDF.format(f"<ixx>{x}</ixx><iyy>{y}</iyy><izz>{z}</izz>")


def in_mjcf(x: float, y: float, z: float) -> str:
    return MJCF.format(f"{x} {y} {z}")


@pytest.mark.parametrize("write", [in_urdf, in_sdf])
@pytest.mark.parametrize("moments", [(0.01, 0.01, 0.5), (-0.01, 0.01, 0.01), (0.0, 0.01, 0.01)])
def test_impossible_inertias_of_props_are_computed_with_a_note(
    write: Callable[[float, float, float], str], moments: tuple[float, float, float]
) -> None:
    assert parse_model(write(0.01, 0.01, 0.01)).notes == ()
    [note] = parse_model(write(*moments)).notes
    assert note == "no body can have the inertia of link 'b': it is computed from mass and shapes"


@pytest.mark.parametrize("moments", [(0.01, 0.01, 0.5), (-0.01, 0.01, 0.01)])
def test_impossible_inertias_in_mjcf_are_refused_by_mujoco(moments: tuple[float, float, float]) -> None:
    with pytest.raises(RequestRefused, match=r"MuJoCo refuses the model: .*inertia"):
        parse_model(in_mjcf(*moments))


@pytest.mark.parametrize("write", [in_urdf, in_sdf])
@pytest.mark.parametrize("moment", [math.nan, 1e30])
def test_inertias_without_meaning_are_refused(write: Callable[[float, float, float], str], moment: float) -> None:
    with pytest.raises(RequestRefused, match="invalid ixx of link 'b'"):
        parse_model(write(moment, moment, moment))


@pytest.mark.parametrize("engine", ["mujoco", "pybullet"])
def test_a_robot_at_a_nan_pose_is_reported_as_a_node_fault(engine: str, monkeypatch: pytest.MonkeyPatch) -> None:
    pytest.importorskip(engine)
    client = Client("maze", engine=engine)
    simulation = client.simulator.simulation
    found = simulation.engine.body_state("turtlebot4")
    lost = replace(found, position=(math.nan, 0.0, 0.0))
    monkeypatch.setattr(type(simulation.engine), "body_state", lambda self, name: lost)
    monkeypatch.setattr(
        type(simulation), "_advance_to", lambda self, until: setattr(self, "_steps", self._steps + 10**6)
    )
    with pytest.raises(RequestRefused, match="the state of the robot 'turtlebot4' is not finite at") as caught:
        client.advance(1.0)
    assert caught.value.code == LabResult.FAULT

from __future__ import annotations

import math

import pytest

from seoro.bridges.wire import SpawnResult
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.extents import lowest_point
from sim_nodes.geometry import quaternion
from sim_nodes.models import parse_model
from sim_nodes.physics import BodyState, Box, Cylinder, Sphere
from tests.sim_nodes.client import BOX


def sdf(link: str, model: str = "") -> str:
    return f'<sdf version="1.9"><model name="m">{model}<link name="l">{link}</link></model></sdf>'


def collision(geometry: str, pose: str = "") -> str:
    return f'<collision name="c">{pose}<geometry>{geometry}</geometry></collision>'


SPHERE = collision("<sphere><radius>0.1</radius></sphere>")

ROUGH = SPHERE.replace(
    "</collision>", "<surface><friction><ode><mu>0.2</mu></ode></friction></surface></collision>"
)


def test_the_box_of_the_examples_stands_on_its_origin() -> None:
    box = parse_model(BOX)
    assert box.parts[0].shape == Box((0.3, 0.3, 0.3))
    assert (box.mass, box.static) == (5.0, False)
    assert lowest_point(box, BodyState((0.0, 0.0, 0.0))) == pytest.approx(0.0)


def test_all_shapes_are_read() -> None:
    shapes = (
        "<box><size>1 2 3</size></box>",
        "<cylinder><radius>0.1</radius><length>0.5</length></cylinder>",
        "<sphere><radius>0.2</radius></sphere>",
    )
    model = parse_model(sdf("".join(collision(shape) for shape in shapes), "<static>true</static>"))
    assert [part.shape for part in model.parts] == [Box((1.0, 2.0, 3.0)), Cylinder(0.1, 0.5), Sphere(0.2)]
    assert model.static


def test_poses_add_up_from_model_to_collision() -> None:
    pose = f"<pose>1 0 0 0 0 {math.pi / 2}</pose>"
    text = sdf(f"{pose}{collision('<sphere><radius>0.2</radius></sphere>', pose)}", pose)
    assert parse_model(text).parts[0].position == pytest.approx((1.0 - 1.0, 1.0, 0.0), abs=1e-9)


def test_poses_in_degrees_are_read() -> None:
    text = sdf(collision("<box><size>1 1 1</size></box>", '<pose degrees="true">0 0 0 0 0 90</pose>'))
    assert parse_model(text).parts[0].orientation == pytest.approx(quaternion(0.0, 0.0, math.pi / 2))


def test_friction_and_mass_are_read() -> None:
    model = parse_model(sdf(f"<inertial><mass>2.5</mass></inertial>{ROUGH}{ROUGH}"))
    assert (model.friction, model.mass) == (0.2, 2.5)


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("<sdf><model>", SpawnResult.RESOURCE_PARSE_ERROR, "invalid XML"),
        ('<!DOCTYPE d [<!ENTITY a "b">]><sdf>&a;</sdf>', SpawnResult.RESOURCE_PARSE_ERROR, "invalid XML"),
        ("<urdf/>", SpawnResult.UNSUPPORTED_FORMAT, "<urdf>"),
        ("<sdf/>", SpawnResult.RESOURCE_PARSE_ERROR, "0 models"),
        (sdf(SPHERE, '<plugin name="p" filename="f"/>'), SpawnResult.RESOURCE_PARSE_ERROR, "<plugin>"),
        (sdf(SPHERE, '<link name="k"/>'), SpawnResult.RESOURCE_PARSE_ERROR, "2 links"),
        (sdf(SPHERE + '<sensor name="s" type="imu"/>'), SpawnResult.RESOURCE_PARSE_ERROR, "<sensor>"),
        (sdf("<gravity>false</gravity>" + SPHERE), SpawnResult.RESOURCE_PARSE_ERROR, "<gravity>"),
        (
            sdf(f"<inertial><pose>1 0 0 0 0 0</pose></inertial>{SPHERE}"),
            SpawnResult.RESOURCE_PARSE_ERROR,
            "<pose>",
        ),
        (sdf(ROUGH + SPHERE), SpawnResult.RESOURCE_PARSE_ERROR, "different friction"),
        (sdf(ROUGH.replace("mu", "mu2")), SpawnResult.RESOURCE_PARSE_ERROR, "<mu2>"),
        (sdf(""), SpawnResult.RESOURCE_PARSE_ERROR, "0 <collision>"),
        (sdf(collision("<mesh/>")), SpawnResult.UNSUPPORTED_ASSETS, "mesh"),
        (
            "<sdf><world name='w'><model name='a'/></world></sdf>",
            SpawnResult.RESOURCE_PARSE_ERROR,
            "unsupported <world> in the SDF file; expected one <model>",
        ),
        (sdf(collision("<plane/>")), SpawnResult.RESOURCE_PARSE_ERROR, "<plane>"),
        (sdf(collision("<box><size>1 2</size></box>")), SpawnResult.RESOURCE_PARSE_ERROR, "3 numbers"),
        (sdf(collision("<box><size>1 2 x</size></box>")), SpawnResult.RESOURCE_PARSE_ERROR, "3 numbers"),
        (sdf(collision("<box><size>1 2 nan</size></box>")), SpawnResult.RESOURCE_PARSE_ERROR, "0.01 to 20"),
        (sdf(collision("<box><size>1 2 1e9</size></box>")), SpawnResult.RESOURCE_PARSE_ERROR, "0.01 to 20"),
        (sdf(collision("<sphere/>")), SpawnResult.RESOURCE_PARSE_ERROR, "<radius>"),
        (sdf(SPHERE, "<static>maybe</static>"), SpawnResult.RESOURCE_PARSE_ERROR, "true or false"),
        (
            sdf(f'<pose relative_to="w">0 0 0 0 0 0</pose>{SPHERE}'),
            SpawnResult.RESOURCE_PARSE_ERROR,
            "relative_to",
        ),
        ("<sdf>" + " " * 1_000_001, SpawnResult.RESOURCE_PARSE_ERROR, "has more than"),
    ],
)
def test_unsupported_elements_are_refused_by_name(text: str, code: SpawnResult, words: str) -> None:
    with pytest.raises(RequestRefused, match=words) as refused:
        parse_model(text)
    assert refused.value.code == code

from __future__ import annotations

import math
from typing import Any

import pytest
from defusedxml import ElementTree

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

MODELS = "".join(f"<model name='{name}'><link name='l'>{SPHERE}</link></model>" for name in "ab")
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
    assert model.urdf is not None
    assert (model.urdf.friction, model.mass) == ({"l": 0.2}, 2.5)


def test_joints_stand_where_their_child_links_are() -> None:
    arm = (
        """
    <joint name="turn" type="revolute">
      <parent>l</parent><child>arm</child><pose>0 0 -0.5 0 0 0</pose>
      <axis><xyz>0 1 0</xyz><limit><lower>-1</lower><upper>1</upper></limit></axis>
    </joint>
    <link name="arm"><pose>0 0 1.5 0 0 0</pose>"""
        + f"{SPHERE}</link>"
    )
    model = parse_model(sdf(SPHERE, arm))
    assert [part.position for part in model.parts] == [(0.0, 0.0, 1.5), (0.0, 0.0, 0.0)]
    assert model.urdf is not None
    robot: Any = ElementTree.fromstring(model.urdf.text)
    assert robot.find("joint/origin").get("xyz") == "0.0 0.0 1.0"
    assert robot.find("link[@name='arm']/collision/origin").get("xyz") == "0.0 0.0 0.5"


def test_poses_relative_to_frames_are_composed() -> None:
    frame = "<frame name='f'><pose>1 0 0 0 0 0</pose></frame>"
    link = f"<link name='k'><pose relative_to='f'>0 1 0 0 0 0</pose>{SPHERE}</link>"
    fixed = "<joint name='j' type='fixed'><parent>l</parent><child>k</child></joint>"
    assert parse_model(sdf(SPHERE, fixed + frame + link)).parts[0].position == (1.0, 1.0, 0.0)


def test_included_models_are_part_of_the_model() -> None:
    include = "<include><uri>model://ball</uri><pose>0 0 2 0 0 0</pose><name>one</name></include>"
    fixed = "<joint name='j' type='fixed'><parent>l</parent><child>one::l</child></joint>"
    files = {"model/ball/model.sdf": sdf(SPHERE).encode()}
    model = parse_model(sdf(SPHERE, include + fixed), files)
    assert sorted(part.position for part in model.parts) == [(0.0, 0.0, 0.0), (0.0, 0.0, 2.0)]


@pytest.mark.parametrize(
    ("limit", "kind"),
    [
        ("<lower>0</lower><upper>1.5</upper>", "revolute"),
        ("<lower>-1.5</lower><upper>0</upper>", "revolute"),
        ("<lower>-1e16</lower><upper>1e16</upper>", "continuous"),
        ("<upper>1</upper>", "revolute"),
        ("", "continuous"),
    ],
)
def test_revolute_joints_with_both_limits_have_them(limit: str, kind: str) -> None:
    hinge = f"""<joint name='j' type='revolute'><parent>l</parent><child>k</child>
    <axis><xyz>0 0 1</xyz><limit>{limit}</limit></axis></joint><link name='k'>{SPHERE}</link>"""
    model = parse_model(sdf(SPHERE, hinge))
    assert model.urdf is not None
    joint: Any = ElementTree.fromstring(model.urdf.text).find("joint")
    assert joint.get("type") == kind


def test_a_limit_may_have_one_side() -> None:
    slide = f"""<joint name='j' type='prismatic'><parent>l</parent><child>k</child>
    <axis><xyz>0 0 1</xyz><limit><lower>-1e16</lower><upper>-0.5</upper></limit></axis></joint>
    <link name='k'>{SPHERE}</link>"""
    model = parse_model(sdf(SPHERE, slide))
    assert model.urdf is not None
    limit: Any = ElementTree.fromstring(model.urdf.text).find("joint/limit")
    assert (limit.get("lower"), limit.get("upper")) == ("-1000.0", "-0.5")


def test_joints_follow_others() -> None:
    joints = "".join(
        f"<joint name='{name}' type='revolute'><parent>l</parent><child>{name}l</child><axis>{mimic}</axis>"
        f"</joint><link name='{name}l'>{SPHERE}</link>"
        for name, mimic in {
            "a": "",
            "b": "<mimic joint='a'><multiplier>2</multiplier><offset>1</offset><reference>0.1</reference></mimic>",
        }.items()
    )
    model = parse_model(sdf(SPHERE, joints))
    assert model.urdf is not None
    mimic: Any = ElementTree.fromstring(model.urdf.text).find("joint/mimic")
    assert (mimic.get("joint"), mimic.get("multiplier"), float(mimic.get("offset"))) == ("a", "2.0", 0.8)


@pytest.mark.parametrize("beside", ["", f"<link name='world'>{SPHERE}</link>"])
def test_a_door_hangs_on_the_world(beside: str) -> None:
    hinge = (
        "<joint name='hinge' type='revolute'><parent>world</parent><child>l</child><axis><xyz>0 0 1</xyz></axis>"
    )
    model = parse_model(sdf(SPHERE, f"{beside}{hinge}</joint>"))
    assert model.static
    assert model.urdf is not None
    assert model.urdf.joints == ("hinge",)


def test_a_joint_to_the_world_fixes_the_model() -> None:
    fixed = "<joint name='j' type='fixed'><parent>world</parent><child>l</child></joint>"
    assert parse_model(sdf(SPHERE, fixed)).static
    assert not parse_model(sdf(SPHERE)).static


@pytest.mark.parametrize(
    ("text", "code", "words"),
    [
        ("<sdf><model>", SpawnResult.RESOURCE_PARSE_ERROR, "invalid XML"),
        ('<!DOCTYPE d [<!ENTITY a "b">]><sdf>&a;</sdf>', SpawnResult.RESOURCE_PARSE_ERROR, "invalid XML"),
        ("<urdf/>", SpawnResult.UNSUPPORTED_FORMAT, "<urdf>"),
        ("<sdf/>", SpawnResult.RESOURCE_PARSE_ERROR, "no shapes besides floors"),
        (
            sdf(SPHERE, f'<link name="k">{SPHERE}</link>'),
            SpawnResult.RESOURCE_PARSE_ERROR,
            "found 2 bodies in the file that move apart: m_k, m_l; expected one",
        ),
        (sdf(""), SpawnResult.RESOURCE_PARSE_ERROR, "no shapes in the model"),
        (
            sdf(collision("<mesh><uri>a.stl</uri></mesh>")),
            SpawnResult.RESOURCE_PARSE_ERROR,
            "missing mesh 'a.stl'",
        ),
        (
            f"<sdf><world name='w'>{MODELS}</world></sdf>",
            SpawnResult.RESOURCE_PARSE_ERROR,
            "found 2 bodies in the file that move apart: a, b; expected one",
        ),
        (sdf(collision("<polyline/>")), SpawnResult.RESOURCE_PARSE_ERROR, "<polyline>"),
        (sdf(collision("<box><size>1 2</size></box>")), SpawnResult.RESOURCE_PARSE_ERROR, "3 numbers"),
        (sdf(collision("<box><size>1 2 x</size></box>")), SpawnResult.RESOURCE_PARSE_ERROR, "3 numbers"),
        (sdf(collision("<box><size>1 2 nan</size></box>")), SpawnResult.RESOURCE_PARSE_ERROR, "0 to 10000"),
        (sdf(collision("<sphere/>")), SpawnResult.RESOURCE_PARSE_ERROR, "radius of <sphere>"),
        (sdf(SPHERE, "<static>maybe</static>"), SpawnResult.RESOURCE_PARSE_ERROR, "true or false"),
        (
            sdf(f'<pose relative_to="w">0 0 0 0 0 0</pose>{SPHERE}'),
            SpawnResult.RESOURCE_PARSE_ERROR,
            "unknown frame 'w'",
        ),
        (
            sdf(SPHERE, "<joint name='j' type='screw'><parent>l</parent><child>k</child></joint><link name='k'/>"),
            SpawnResult.RESOURCE_PARSE_ERROR,
            "unsupported type 'screw'",
        ),
        (
            sdf(SPHERE, "<include><uri>model://none</uri></include>"),
            SpawnResult.RESOURCE_PARSE_ERROR,
            "missing model 'model://none' of <include>",
        ),
        ("<sdf>" + " " * 4_000_001 + "</sdf>", SpawnResult.RESOURCE_PARSE_ERROR, "has more than"),
    ],
)
def test_invalid_models_are_refused_with_the_place(text: str, code: SpawnResult, words: str) -> None:
    with pytest.raises(RequestRefused, match=words) as refused:
        parse_model(text)
    assert refused.value.code == code


def test_materials_of_gazebo_have_their_colours() -> None:
    def painted(name: str) -> str:
        script = (
            f"<material><script><uri>file://media/gazebo.material</uri><name>{name}</name></script></material>"
        )
        return sdf(
            f'{SPHERE}<visual name="v"><geometry><sphere><radius>0.1</radius></sphere></geometry>{script}</visual>'
        )

    assert parse_model(painted("Gazebo/Orange")).colour == pytest.approx((1.0, 0.51, 0.05, 1.0))
    unknown = parse_model(painted("Gazebo/Fur"))
    assert unknown.colour is None
    assert "without effect: the unknown material 'Gazebo/Fur' of <script>" in unknown.notes

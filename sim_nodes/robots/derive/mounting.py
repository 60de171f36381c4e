"""Robots that are mounted on the base of another one, such as an arm on a mobile base."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from copy import deepcopy
from dataclasses import replace
from typing import Any, TypeVar

from defusedxml import ElementTree
from pydantic import Field, ValidationError

from seoro.bridges.wire.refusal import name_list
from seoro.deferred import dataclass
from sim_nodes.files import NAME
from sim_nodes.models import xml_reading as xml
from sim_nodes.models.urdf import write_joint
from sim_nodes.physics import Urdf
from sim_nodes.robots.declaration import ArmDeclaration, CameraDeclaration, RobotDeclaration
from sim_nodes.robots.derive.jointed import given_home
from sim_nodes.robots.derive.rewriting import urdf_text
from sim_nodes.robots.postures import Posture
from sim_nodes.robots.sensor_declarations import LinkPart, Mount, SensorDeclaration

P = TypeVar("P", bound=LinkPart)


class MountingDeclaration(Mount):
    """Mounting of a robot: a link of the base, and the pose of the robot's own base there.

    Attributes:
        robot: Name of the robot, or path of its declaration.
        link: Link that carries it; None for the root.
        prefix: Put before the names of its links and joints.
    """

    robot: str = Field(min_length=1)
    link: str | None = None
    prefix: str = Field("arm_", pattern=NAME)


@dataclass(frozen=True)
class Mounted:
    """A base with a robot on it.

    Attributes:
        urdf: Canonical URDF of both.
        arm: Declaration of the arm.
        cameras: Cameras of the mounted robot.
        sensors: Its sensors.
        postures: Its postures.
    """

    urdf: Urdf
    arm: ArmDeclaration
    cameras: tuple[CameraDeclaration, ...]
    sensors: tuple[SensorDeclaration, ...]
    postures: tuple[Posture, ...]


def read_mounting(content: Mapping[str, object]) -> MountingDeclaration:
    """Read `mounted` of a short declaration.

    Raises:
        RequestRefused: It is invalid.
    """
    try:
        return MountingDeclaration.model_validate(content["mounted"])
    except ValidationError as error:
        first = error.errors()[0]
        where = ".".join(map(str, ("mounted", *first["loc"])))
        wanted = "such as {robot: ur10e, link: top_plate, z: 0.1}"
        raise xml.invalid(f"invalid `{where}`: {first['msg']}; expected a mapping {wanted}") from error


def mount(
    base: Urdf, carried: RobotDeclaration, mounting: MountingDeclaration, home: Mapping[str, float]
) -> Mounted:
    """Mount a robot with an arm on a base.

    Args:
        base: Canonical URDF of the base.
        carried: The robot.
        mounting: Its place on the base.
        home: Initial positions of its joints by name or pattern, instead of its own [rad], [m].

    Raises:
        RequestRefused: The robot has no arm, or names do not fit.
    """
    if carried.arm is None or carried.mobile is not None:
        raise xml.invalid(
            f"invalid `mounted.robot` {mounting.robot!r}; expected a robot with an arm, without a drive"
        )
    root: Any = ElementTree.fromstring(base.text)
    links = [str(link.get("name")) for link in root.findall("link")]
    below = {str(joint.find("child").get("link")) for joint in root.findall("joint")}
    carrier = mounting.link or next(link for link in links if link not in below)
    if carrier not in links:
        raise xml.invalid(f"unknown `mounted.link` {carrier!r}; the base has {name_list(links)}")
    own = {str(each.get("name")) for each in root}
    for element in _renamed(ElementTree.fromstring(carried.urdf), mounting.prefix):
        if element.get("name") in own:
            raise xml.invalid(f"duplicate name {element.get('name')!r}; expected another `mounted.prefix`")
        root.append(element)
    foot = f"{mounting.prefix}{carried.base_link}"
    write_joint(root, f"{foot}_mount", "fixed", carrier, foot, (mounting.position, mounting.orientation))
    meshes = {**base.meshes, **{f"{mounting.prefix}{name}": data for name, data in carried.meshes}}
    return Mounted(
        replace(base, text=urdf_text(root), meshes=meshes),
        _moved_home(_renamed_arm(carried.arm, mounting.prefix), home),
        _on_renamed_links(carried.cameras, mounting.prefix),
        _on_renamed_links(carried.sensors, mounting.prefix),
        tuple(posture.renamed(mounting.prefix) for posture in carried.postures),
    )


def _renamed(root: Any, prefix: str) -> list[Any]:
    """Return copies of the links and joints of a URDF with a prefix before all names."""
    elements = [deepcopy(each) for each in root if each.tag in ("link", "joint")]
    for element in elements:
        element.set("name", f"{prefix}{element.get('name')}")
        for tag, key in (("parent", "link"), ("child", "link"), ("mimic", "joint")):
            for each in element.findall(tag):
                each.set(key, f"{prefix}{each.get(key)}")
        for mesh in element.iter("mesh"):
            mesh.set("filename", f"{prefix}{mesh.get('filename')}")
    return elements


def _renamed_arm(arm: ArmDeclaration, prefix: str) -> ArmDeclaration:
    """Return the declaration of an arm with a prefix before all names."""
    gripper = arm.gripper
    if gripper is not None:
        joints, links = (tuple(f"{prefix}{each}" for each in both) for both in (gripper.joints, gripper.links))
        gripper = gripper.model_copy(update={"joints": joints, "links": links})
    return arm.model_copy(
        update={
            "tool_link": None if arm.tool_link is None else f"{prefix}{arm.tool_link}",
            "joints": tuple(each.model_copy(update={"name": f"{prefix}{each.name}"}) for each in arm.joints),
            "gripper": gripper,
        }
    )


def _moved_home(arm: ArmDeclaration, home: Mapping[str, float]) -> ArmDeclaration:
    """Return the declaration of an arm with other initial positions."""
    given = given_home(home, [joint.name for joint in arm.joints])
    joints = (joint.model_copy(update={"home": given.get(joint.name, joint.home)}) for joint in arm.joints)
    return arm.model_copy(update={"joints": tuple(joints)})


def _on_renamed_links(parts: Sequence[P], prefix: str) -> tuple[P, ...]:
    return tuple(part.model_copy(update={"link": f"{prefix}{part.link}"}) for part in parts)

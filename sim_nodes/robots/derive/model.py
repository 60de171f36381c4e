"""A robot's model in a posture: links, joints, frames and solid shapes in the frame of its root."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterator, Mapping
from dataclasses import replace
from functools import cached_property
from typing import Any

import numpy as np
from defusedxml import ElementTree

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Frame, Vector, compose_frames, multiply, rotated, vector
from sim_nodes.models import xml_reading as xml
from sim_nodes.models.stl import hull_of_stl
from sim_nodes.models.urdf import frame_of, read_origin, read_shape
from sim_nodes.physics import IDENTITY, Part, Urdf


@dataclass(frozen=True)
class ModelJoint:
    """A joint of a model.

    Attributes:
        name: Its name.
        kind: Its type in URDF.
        parent: Link that carries it.
        child: Link that it moves.
        axis: Unit vector in the frame of the root.
        lower: Lower limit [rad], [m]; infinite without one.
        upper: Upper limit [rad], [m]; infinite without one.
        effort: Limit of its motor [N m], [N]; infinite without one.
        velocity: Limit of its speed [rad/s], [m/s]; infinite without one.
        mimic: Name of the joint that it follows, and factor and offset of its position; None if it follows none.
    """

    name: str
    kind: str
    parent: str
    child: str
    axis: Vector
    lower: float
    upper: float
    effort: float
    velocity: float
    mimic: tuple[str, float, float] | None = None

    @property
    def is_movable(self) -> bool:
        """Whether it moves."""
        return self.kind != "fixed"

    @property
    def turns(self) -> bool:
        """Whether it turns about an axis."""
        return self.kind in ("revolute", "continuous")

    @property
    def slides(self) -> bool:
        """Whether it slides along its axis."""
        return self.kind == "prismatic"

    @property
    def is_limited(self) -> bool:
        """Whether it has a lower and an upper limit."""
        return math.isfinite(self.lower) and math.isfinite(self.upper)


@dataclass(frozen=True)
class RobotModel:
    """A model of a robot.

    Attributes:
        urdf: Its canonical URDF.
        root: Name of the root link.
        joints: Joints by the name of the link that they move.
        frames: Frames of links in that of the root.
        solids: Solid shapes of links, in the frame of the root.
        masses: Masses of links [kg].
        centres: Centres of mass of links in the frame of the root [m].
    """

    urdf: Urdf
    root: str
    joints: Mapping[str, ModelJoint]
    frames: Mapping[str, Frame]
    solids: Mapping[str, tuple[Part, ...]]
    masses: Mapping[str, float]
    centres: Mapping[str, Vector]

    @cached_property
    def mass(self) -> float:
        """Mass of the robot [kg]."""
        return sum(self.masses.values())

    def ancestors(self, link: str) -> Iterator[ModelJoint]:
        """Yield the joints from a link to the root."""
        while link in self.joints:
            yield self.joints[link]
            link = self.joints[link].parent

    def followers(self, leaders: Collection[str]) -> tuple[ModelJoint, ...]:
        """Return the joints that follow some joints."""
        return tuple(each for each in self.joints.values() if each.mimic is not None and each.mimic[0] in leaders)

    def carrier(self, link: str) -> str:
        """Return the link that a link is fixed to through fixed joints, nearest to the root."""
        for joint in self.ancestors(link):
            if joint.is_movable:
                return joint.child
        return self.root

    def at(self, positions: Mapping[str, float]) -> RobotModel:
        """Return the model with some joints at positions [rad], [m], by their names."""
        motions = {link: _motion(self, link, positions) for link in self.frames}
        return replace(
            self,
            joints={
                link: replace(joint, axis=rotated(motions[link][1], joint.axis))
                for link, joint in self.joints.items()
            },
            frames={link: compose_frames(motions[link], frame) for link, frame in self.frames.items()},
            solids={
                link: tuple(part.placed(*motions[link]) for part in parts) for link, parts in self.solids.items()
            },
            centres={
                link: compose_frames(motions[link], (centre, IDENTITY))[0] for link, centre in self.centres.items()
            },
        )


def _motion(model: RobotModel, link: str, positions: Mapping[str, float]) -> Frame:
    """Return how joints move a link from its place with all joints at zero, by the product of exponentials."""
    place, turn = np.zeros(3), IDENTITY
    for joint in model.ancestors(link):
        position = positions.get(joint.name, 0.0)
        if joint.slides:
            place = place + position * np.array(joint.axis)
            continue
        x, y, z = (math.sin(position / 2.0) * value for value in joint.axis)
        rotation = (math.cos(position / 2.0), x, y, z)
        origin: Array = np.array(model.frames[joint.child][0])
        place = origin + np.array(rotated(rotation, vector(place - origin)))
        turn = multiply(rotation, turn)
    return vector(place), turn


def read_model(urdf: Urdf) -> RobotModel:
    """Read a model from canonical URDF."""
    root: Any = ElementTree.fromstring(urdf.text)
    links = {str(link.get("name")): link for link in root.findall("link")}
    elements = {str(joint.find("child").get("link")): joint for joint in root.findall("joint")}
    hung = {child: (str(each.find("parent").get("link")), read_origin(each)) for child, each in elements.items()}
    frames = {name: frame_of(name, hung) for name in links}
    [top] = links.keys() - elements.keys()
    return RobotModel(
        urdf,
        top,
        {child: _joint(each, child, frames[child]) for child, each in elements.items()},
        frames,
        {name: tuple(_solids(link, frames[name], urdf)) for name, link in links.items()},
        {name: float(link.find("inertial/mass").get("value")) for name, link in links.items()},
        {
            name: compose_frames(frames[name], read_origin(link.find("inertial")))[0]
            for name, link in links.items()
        },
    )


def _solids(link: Any, frame: Frame, urdf: Urdf) -> Iterator[Part]:
    for collision in link.findall("collision"):
        [shape] = collision.find("geometry")
        if shape.tag == "mesh":
            solid = Part(hull_of_stl(urdf.meshes[shape.get("filename")]), *read_origin(collision))
        else:
            solid = Part(read_shape(shape, xml.label(collision)), *read_origin(collision))
        yield xml.moved(solid, frame)


def _joint(element: Any, child: str, frame: Frame) -> ModelJoint:
    axis, limit, mimic = element.find("axis"), element.find("limit"), element.find("mimic")
    x, y, z = (1.0, 0.0, 0.0) if axis is None else map(float, axis.get("xyz").split())
    limits: Mapping[str, str] = {} if limit is None else limit.attrib
    return ModelJoint(
        str(element.get("name")),
        str(element.get("type")),
        str(element.find("parent").get("link")),
        child,
        rotated(frame[1], (x, y, z)),
        float(limits.get("lower", -math.inf)),
        float(limits.get("upper", math.inf)),
        float(limits.get("effort", math.inf)),
        float(limits.get("velocity", math.inf)),
        None
        if mimic is None
        else (str(mimic.get("joint")), float(mimic.get("multiplier", "1")), float(mimic.get("offset", "0"))),
    )

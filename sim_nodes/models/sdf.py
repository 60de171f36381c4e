"""Translates models of SDF (http://sdformat.org) to URDF, which all engines read.

SDF gives poses of links in the frame of their model, and those of joints in the frame of their child link. URDF
gives the pose of a joint in the frame of its parent link, and the child link has the frame of its joint.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any
from xml.etree.ElementTree import Element, SubElement

from seoro.bridges.model_files import virtual_path
from seoro.bridges.wire.refusal import name_list
from seoro.deferred import dataclass
from sim_nodes.geometry import Frame, compose_frames, inverse_frame, roll_pitch_yaw
from sim_nodes.models import xml_reading as xml
from sim_nodes.models.gazebo_materials import COLOURS
from sim_nodes.models.sdf_elements import SdfModel, included_model, name_of, pose_of
from sim_nodes.models.urdf import SCRIPT, WORLD_LINK, text_of, write_joint, write_origin

JOINTS = {
    "revolute": "revolute",
    "continuous": "continuous",
    "prismatic": "prismatic",
    "fixed": "fixed",
    "ball": "spherical",
}
INERTIA = dict.fromkeys(xml.INERTIA, "0") | {"ixx": "1", "iyy": "1", "izz": "1"}  # defaults of the specification
UNLIMITED = 1e15  # [rad], [m]; SDF's default limit is 1e16
FAR = 1e3  # [rad], [m] of the missing side of a limit
FACTORS = (-1e6, 1e6)
PICTURES = ("material/pbr/metal/albedo_map", "material/pbr/specular/albedo_map")
MODEL = "__model__"  # frame of a model
MAX_INCLUDES = 20  # nested
LENGTHS = {
    "box": ("size",),
    "cylinder": ("radius", "length"),
    "sphere": ("radius",),
    "capsule": ("radius", "length"),
}


@dataclass(frozen=True)
class _Link:
    """A link with its pose in the outermost model; `folder` is that of its files."""

    element: Any
    pose: Frame
    folder: str


@dataclass(frozen=True)
class _Joint:
    element: Any
    parent: str  # `WORLD_LINK` for the world
    child: str

    @property
    def holds(self) -> bool:
        """Whether the joint fixes its child to the world."""
        return self.parent == WORLD_LINK and self.element.get("type") == "fixed"


class _Tree:
    """Links and joints of a model and the models in it, by names with the names of their models before `::`."""

    def __init__(self, files: Mapping[str, bytes]) -> None:
        self._files = files
        self._links: dict[str, tuple[Any, str]] = {}
        self.joints: dict[str, _Joint] = {}
        self._frames: dict[str, tuple[Frame, str]] = {}  # poses in other frames; those of no name are final

    def add(self, model: Any, scope: str, folder: str, depth: int = MAX_INCLUDES) -> None:
        """Add a model whose frame is known; names in it begin with `scope`."""
        if not depth:
            raise xml.invalid(f"models include each other more than {MAX_INCLUDES} times")
        own = f"{scope}{MODEL}"
        for link in model.findall("link"):
            self._add_frame(scope, name_of(link), link, own)
            self._links[scope + name_of(link)] = (link, folder)
        for frame in model.findall("frame"):
            attached = frame.get("attached_to")
            self._add_frame(scope, name_of(frame), frame, scope + attached if attached else own)
        for joint in model.findall("joint"):
            parent, child = (_end(joint, key) for key in ("parent", "child"))
            self.joints[scope + name_of(joint)] = _Joint(
                joint, WORLD_LINK if parent == "world" else scope + parent, scope + child
            )
            self._add_frame(scope, name_of(joint), joint, scope + child)
        for inner in model.findall("model"):
            self._add_model(scope, name_of(inner), inner, inner, folder, depth)
        for include in model.findall("include"):
            inner, inside = included_model(include, self._files, folder)
            name = (include.findtext("name") or "").strip() or name_of(inner)
            posed = inner if include.find("pose") is None else include
            self._add_model(scope, name, inner, posed, inside, depth)

    def place(self, pose: Frame) -> None:
        """Set the pose of the outermost model."""
        self._frames[MODEL] = (pose, "")

    def _add_model(self, scope: str, name: str, model: Any, posed: Any, folder: str, depth: int) -> None:
        self._add_frame(scope, f"{name}::{MODEL}", posed, f"{scope}{MODEL}")
        self._frames[scope + name] = (xml.ORIGIN, f"{scope}{name}::{MODEL}")
        self.add(model, f"{scope}{name}::", folder, depth - 1)

    def _add_frame(self, scope: str, name: str, element: Any, usual: str) -> None:
        """Add the frame of an element, with its pose in the frame `usual`, or in that of `relative_to`."""
        if scope + name in self._frames:
            raise xml.invalid(f"duplicate name {scope + name!r} in the model")
        pose = element.find("pose")
        relative = None if pose is None else pose.get("relative_to") or pose.get("frame")
        self._frames[scope + name] = (pose_of(element), scope + relative if relative else usual)

    def pose(self, name: str) -> Frame:
        """Return the pose of a frame in that of the file."""
        found, chain = xml.ORIGIN, 0
        while name:
            if name not in self._frames or chain > len(self._frames):
                raise xml.invalid(f"unknown frame {name!r} of a <pose>, or frames are relative to each other")
            own, name = self._frames[name]
            found, chain = compose_frames(own, found), chain + 1
        return found

    def links(self) -> dict[str, _Link]:
        """Return all links, with their poses in the frame of the file."""
        return {name: _Link(link, self.pose(name), folder) for name, (link, folder) in self._links.items()}


@dataclass(frozen=True)
class SdfBody:
    """A body of an SDF model: its name, root element of its URDF, and frame in the file."""

    name: str
    urdf: Element
    frame: Frame


def translate_sdf(model: SdfModel, files: Mapping[str, bytes], *, apart: bool) -> list[SdfBody]:
    """Translate a model; links that no joint connects are bodies of their own, unless the world holds some.

    Args:
        model: The model.
        files: Files of the model by virtual path.
        apart: Whether the bodies have frames of their own; else they have that of the file, if there is one body.

    Raises:
        RequestRefused: The model is invalid, or has parts that URDF cannot express.
    """
    tree = _Tree(files)
    tree.place(model.pose)
    tree.add(model.element, "", model.folder)
    links = tree.links()
    for name, joint in tree.joints.items():
        _check_ends(name, joint, links)
    is_one = model.static or not links or any(joint.parent == WORLD_LINK for joint in tree.joints.values())
    bodies = [tuple(links)] if is_one else _connected(links, tree.joints)
    if len(bodies) == 1 and not apart:
        return [SdfBody(model.name, _translate(model, tree, bodies[0]), xml.ORIGIN)]
    found = []
    for body in bodies:
        tree.place(model.pose)
        frame = model.pose if len(bodies) == 1 else tree.pose(body[0])
        tree.place(compose_frames(inverse_frame(frame), model.pose))
        name = model.name if len(bodies) == 1 else f"{model.name}::{body[0]}"
        found.append(SdfBody(name, _translate(model, tree, body), frame))
    return found


def _connected(links: Mapping[str, _Link], joints: Mapping[str, _Joint]) -> list[tuple[str, ...]]:
    """Return the links that joints connect with each other, the root of each body first."""
    bodies: dict[str, list[str]] = {name: [name] for name in links}
    for joint in joints.values():
        parent, child = bodies[joint.parent], bodies[joint.child]
        if parent is not child:
            parent += child
            bodies |= dict.fromkeys(child, parent)
    children = {joint.child for joint in joints.values()}
    return [
        tuple(sorted(body, key=lambda name: name in children))
        for body in {id(body): body for body in bodies.values()}.values()
    ]


def _translate(model: SdfModel, tree: _Tree, body: tuple[str, ...]) -> Element:
    """Translate some links of a model with their joints; returns the root element of a URDF."""
    links = {name: link for name, link in tree.links().items() if name in body}
    joints = {name: joint for name, joint in tree.joints.items() if joint.child in body}
    moving = {name: joint for name, joint in joints.items() if not joint.holds}
    is_fixed = model.static or len(moving) < len(joints)
    # The frame of a URDF link is that of its joint, and that of the root is the frame of the file.
    frames = {name: link.pose for name, link in links.items()}
    frames |= {joint.child: tree.pose(name) for name, joint in moving.items()}
    roots = [name for name in links if name not in {joint.child for joint in moving.values()}]
    if len(roots) > 1 and not is_fixed:
        raise xml.invalid(f"found {len(roots)} links without a joint: {name_list(roots)}; expected one")
    out = Element("robot", name=model.name)
    # A base holds links that stand still together, or hang on the world by joints that move.
    has_base = len(roots) != 1 or any(joint.parent == WORLD_LINK for joint in moving.values())
    if has_base:
        SubElement(SubElement(SubElement(out, "link", name=WORLD_LINK), "inertial"), "mass", value="0")
        for name in roots:
            write_joint(out, f"{name}::fixed", "fixed", WORLD_LINK, name, frames[name])
    else:
        frames[roots[0]] = xml.ORIGIN
    for name, link in links.items():
        offset = compose_frames(inverse_frame(frames[name]), link.pose)
        _link(out, name, link, offset, is_held=is_fixed and not has_base and name == roots[0])
    for name, joint in moving.items():
        parent = frames.get(joint.parent, xml.ORIGIN)
        _joint(out, name, joint, compose_frames(inverse_frame(parent), frames[joint.child]))
    return out


def _check_ends(name: str, joint: _Joint, links: Mapping[str, _Link]) -> None:
    for end, link in (("child", joint.child), ("parent", joint.parent)):
        if link not in links and (end, link) != ("parent", WORLD_LINK):
            raise xml.invalid(f"<joint name={name!r}>: unknown {end} link {link!r}")


def _link(out: Element, name: str, link: _Link, offset: Frame, *, is_held: bool) -> None:
    """Write a link, whose frame is at `offset` in its frame in the URDF; a held one does not move."""
    written = SubElement(out, "link", name=name)
    inertial, own = link.element.find("inertial"), SubElement(written, "inertial")
    place, turn = offset if inertial is None else compose_frames(offset, pose_of(inertial))
    write_origin(own, place, roll_pitch_yaw(turn))
    mass = "1" if inertial is None else inertial.findtext("mass", "1")
    SubElement(own, "mass", value="0" if is_held else mass)
    for inertia in link.element.findall("inertial/inertia"):
        SubElement(own, "inertia", {key: inertia.findtext(key, usual) for key, usual in INERTIA.items()})
    friction = link.element.findtext("collision/surface/friction/ode/mu")
    if friction is not None:
        SubElement(SubElement(written, "contact"), "lateral_friction", value=friction)
    for purpose in ("collision", "visual"):
        for element in link.element.findall(purpose):
            shape = next(iter(element.find("geometry") if element.find("geometry") is not None else ()), None)
            if shape is None or shape.tag == "empty":
                continue
            own = SubElement(written, purpose)
            place, turn = compose_frames(offset, pose_of(element))
            write_origin(own, place, roll_pitch_yaw(turn))
            _shape(SubElement(own, "geometry"), shape, link.folder)
            _material(own, element, link.folder)


def _material(out: Element, visual: Any, folder: str) -> None:
    """Write the colour and the picture of a <visual>."""
    diffuse = visual.findtext("material/diffuse")
    picture = next((found for path in PICTURES if (found := visual.findtext(path))), None)
    script = (visual.findtext("material/script/name") or "").strip()
    if diffuse is None and picture is None and not script:
        return
    material = SubElement(out, "material", name="")
    if diffuse is None and picture is None:
        if script in COLOURS:
            SubElement(material, "color", rgba=text_of(COLOURS[script]))
        else:
            material.set(SCRIPT, script)
    if diffuse is not None:
        count = 3 if len(diffuse.split()) == 3 else 4
        colour = [*xml.numbers(diffuse, "<diffuse>", count, (0.0, 1.0)), 1.0][:4]
        SubElement(material, "color", rgba=text_of(colour))
    if picture is not None:
        SubElement(material, "texture", filename=virtual_path(picture, folder))


def _shape(out: Element, shape: Any, folder: str) -> None:
    if shape.tag == "mesh":
        values = {"filename": virtual_path(shape.findtext("uri", ""), folder)}
        SubElement(out, "mesh", values | {"scale": shape.findtext("scale", "1 1 1")})
    elif shape.tag in LENGTHS:
        SubElement(out, shape.tag, {key: shape.findtext(key, "") for key in LENGTHS[shape.tag]})
    else:
        SubElement(out, shape.tag)


def _joint(out: Element, name: str, joint: _Joint, frame: Frame) -> None:
    element = joint.element
    kind = element.get("type")
    if kind not in JOINTS:
        raise xml.invalid(f"<joint name={name!r}> has the unsupported type {kind!r}; expected {name_list(JOINTS)}")
    axis = element.find("axis")
    limit = {key: _limit(axis, key) for key in ("lower", "upper", "effort", "velocity")}
    known = {key: value for key, value in limit.items() if value is not None and abs(value) < UNLIMITED}
    if "lower" in known or "upper" in known:  # the other side is far away
        known = {"lower": -FAR, "upper": FAR} | known
    kind = "continuous" if kind == "revolute" and "lower" not in known else JOINTS[kind]
    written = write_joint(out, name, kind, joint.parent, joint.child, frame)
    if axis is None:
        return
    SubElement(written, "axis", xyz=axis.findtext("xyz", "0 0 1"))
    if known:
        SubElement(written, "limit", {key: repr(value) for key, value in known.items()})
    mimic = axis.find("mimic")
    if mimic is not None:
        _mimic(written, name, mimic)
    dynamics = axis.find("dynamics")
    if dynamics is not None:
        SubElement(written, "dynamics", {key: dynamics.findtext(key, "0") for key in ("damping", "friction")})


def _mimic(out: Element, name: str, mimic: Any) -> None:
    """Write the <mimic> of a joint: it is at multiplier * (leader - reference) + offset."""
    leader = mimic.get("joint")
    if not leader:
        raise xml.invalid(f"missing joint of the <mimic> of <joint name={name!r}>")
    factor, offset, reference = (
        xml.numbers(mimic.findtext(key, usual), f"<{key}> of <mimic>", 1, FACTORS)[0]
        for key, usual in (("multiplier", "1"), ("offset", "0"), ("reference", "0"))
    )
    scope = name.rpartition("::")
    values = {"multiplier": repr(factor), "offset": repr(offset - factor * reference)}
    SubElement(out, "mimic", {"joint": f"{scope[0]}{scope[1]}{leader}"} | values)


def _limit(axis: Any, key: str) -> float | None:
    text = None if axis is None else axis.findtext(f"limit/{key}")
    if text is None:
        return None
    try:
        return float(text)
    except ValueError:
        raise xml.invalid(f"invalid <{key}>: {text!r}; expected a number") from None


def _end(joint: Any, key: str) -> str:
    element = joint.find(key)
    text = "" if element is None else (element.text or "").strip() or (element.findtext("link_name") or "").strip()
    if not text:
        raise xml.invalid(f"{xml.label(joint)} has no <{key}>")
    return text.removeprefix("__model__::")

"""Canonical URDF: model files in a form that all engines read alike.

Each engine reads a URDF in its own way: one skips unknown elements and invalid numbers, another gives massless
links a kilogram, a third refuses the file. So models are brought into one form first: known elements only, valid
numbers, complete inertia. Meshes are without folders, in STL, or in OBJ if they have a picture; solid ones are
convex pieces. Notes list the changes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any
from xml.etree.ElementTree import Element, SubElement, tostring

import numpy as np

from seoro.bridges.model_files import virtual_path
from seoro.bridges.wire.refusal import name_list
from sim_nodes.geometry import Array, Vector, quaternion, rotated, vector
from sim_nodes.inertia import inertia_tensor, masses_by_volume, volume
from sim_nodes.models import xml_reading as xml
from sim_nodes.models.canonical_joints import JOINT_ELEMENTS, ends_of, root_of, write_joint, write_pose
from sim_nodes.models.settings import ModelSettings
from sim_nodes.models.urdf import (
    FIELD,
    SCRIPT,
    frame_of,
    read_numbers,
    read_origin,
    read_pose,
    read_shape,
    text_of,
    write_shape,
)
from sim_nodes.physics import BodyModel, Box, Capsule, Part, Shape, Urdf
from sim_nodes.views import Colour

if TYPE_CHECKING:
    from sim_nodes.models.mesh_files import MeshFile, MeshFiles

REPEATED = frozenset({"visual", "collision", "contact"})
DENSITY = 1000.0  # [kg/m^3] of links without a mass
SMALLEST = 1e-6  # smallest ratio of principal moments
FRAME_MASS, FRAME_INERTIA = 1e-3, 1e-6  # [kg], [kg m^2] of links without shapes and mass
WHITE: Colour = (1.0, 1.0, 1.0, 1.0)  # of pictures
CENTRE: tuple[Vector, Vector] = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0))
POINT_RADIUS = 0.05  # [m] of the sphere that stands for a link with a mass, without shapes
PLANE = (100.0, 100.0, 1.0)  # [m] of the box whose top stands for a plane
MASSES = (0.0, 1e5)  # [kg]
MAX_SHAPES = 1000


def canonical_model(robot: Any, files: Mapping[str, bytes], settings: ModelSettings) -> BodyModel:
    """Bring a URDF into canonical form.

    Args:
        robot: Root element.
        files: Files of the model by virtual path.
        settings: Settings of the reader.

    Raises:
        RequestRefused: The model is invalid.
    """
    return _Writer(robot, files, settings).write()


class _Writer:
    """Writes the canonical form of a URDF."""

    def __init__(self, robot: Any, files: Mapping[str, bytes], settings: ModelSettings) -> None:
        self._robot, self._files, self._settings, self._colour = robot, files, settings, settings.colour
        self._out = Element("robot", name=robot.get("name") or "model")
        self._ignored: set[str] = set()
        self._notes: dict[str, None] = {}
        self._meshes: MeshFiles | None = None
        self._materials = {(each.get("name"), part.tag): part for each in robot.iter("material") for part in each}
        self._friction: dict[str, float] = {}
        self._first_colour: Colour | None = None
        self._shapes = 0
        self._is_static = False

    def write(self) -> BodyModel:
        robot = self._robot
        links = {link.get("name"): link for link in robot.findall("link")}
        if None in links or len(links) != len(robot.findall("link")):
            raise xml.invalid("missing or duplicate name of a <link>")
        self._ignore(robot, {"link", "joint", "material"})
        self._note_repeated(robot)
        joints = [(joint, *ends_of(joint, links), read_origin(joint)) for joint in robot.findall("joint")]
        root = root_of(links, [child for _, _, child, _ in joints])
        hung = {child: (parent, frame) for _, parent, child, frame in joints}
        is_solid = robot.find("link/collision") is not None
        is_static = self._is_static = (
            self._settings.static or not is_solid or _given_mass(links[root]) == 0.0 or _is_world(links[root])
        )
        parts: list[Part] = []
        mass = 0.0
        for name, link in links.items():
            frame = frame_of(name, hung)
            own, weight = self._link(name, link, is_held=is_static and name == root)
            parts += [xml.moved(part, frame) for part in own]
            mass += weight
        for joint, parent, child, _ in joints:
            self._ignore(joint, JOINT_ELEMENTS)
            write_joint(self._out, joint, parent, child, self._note)
        if not self._shapes:
            raise xml.invalid("found no shapes in the model; expected one or more")
        if not parts:
            self._note("without collision shapes: the model is fixed, and nothing touches it")
        if not is_static and mass > MASSES[1]:
            raise xml.invalid(f"the model has a mass of {mass:g} kg; expected at most {MASSES[1]:g} kg")
        movable = tuple(joint.get("name") for joint, *_ in joints if joint.get("type") != "fixed")
        text = tostring(self._out, encoding="unicode").replace("><", ">\n<")
        return BodyModel(
            tuple(parts),
            mass=mass,
            static=is_static or not parts,
            colour=self._colour or self._first_colour,
            urdf=Urdf(text, {} if self._meshes is None else self._meshes.written, movable, self._friction),
            notes=self._all_notes(),
        )

    def _all_notes(self) -> tuple[str, ...]:
        if not self._ignored:
            return tuple(self._notes)
        return (f"without effect: {name_list(f'<{name}>' for name in sorted(self._ignored))}", *self._notes)

    def _note(self, text: str) -> None:
        self._notes[text] = None

    def _note_repeated(self, robot: Any) -> None:
        """Note elements of which only the first counts."""
        for tag, inside in (("link", ("inertial", "visual", "collision")), ("joint", ())):
            for outer in robot.findall(tag):
                for element in (outer, *(each for name in inside for each in outer.findall(name))):
                    tags = Counter(str(child.tag) for child in element)
                    for name in (name for name, count in tags.items() if count > 1 and name not in REPEATED):
                        self._note(f"without effect: a second <{name}> of {xml.label(outer)}")

    def _ignore(self, element: Any, known: set[str]) -> None:
        self._ignored |= {str(child.tag) for child in element} - known

    # ------------------------------------------------------------ links

    def _link(self, name: str, link: Any, *, is_held: bool) -> tuple[list[Part], float]:
        """Write a link; returns its solid shapes in its frame, and its mass [kg], 0 if it is held."""
        self._ignore(link, {"inertial", "visual", "collision", "contact"})
        out = SubElement(self._out, "link", name=name)
        solids: list[Part] = []
        for element in link:  # in the order of the file, which is that of geoms in engines
            if element.tag == "collision":
                solids += self._solids(out, element)
            elif element.tag == "visual":
                self._visual(out, element)
        self._shapes += len(out)
        if self._shapes > MAX_SHAPES:
            raise xml.invalid(f"the model has more than {MAX_SHAPES} shapes")
        for contact in link.findall("contact"):
            self._ignore(contact, {"lateral_friction"})
            for friction in contact.findall("lateral_friction"):
                [self._friction[name]] = read_numbers(
                    friction.get("value"), f"<lateral_friction> of {xml.label(link)}", 1, xml.FRICTIONS
                )
        if is_held:
            _write_inertial(out, 1.0, CENTRE, np.eye(3))  # engines need some inertia
            return solids, 0.0
        return solids, self._inertial(out, name, link, solids)

    def _inertial(self, out: Element, name: str, link: Any, solids: Sequence[Part]) -> float:
        """Write the <inertial> of a link that may move; returns its mass [kg]."""
        given = link.find("inertial")
        mass = _given_mass(link)
        if not mass and not solids:
            _write_inertial(out, FRAME_MASS, CENTRE, FRAME_INERTIA * np.eye(3))
            return FRAME_MASS
        if not mass:
            mass = DENSITY * sum(volume(part.shape) for part in solids)
            self._note(f"link {name!r} has no mass: {mass:.3g} kg by its volume, at {DENSITY:g} kg/m^3")
        own = None if given is None else self._given_tensor(name, given)
        if own is not None:
            _write_inertial(out, mass, read_pose(given), own)
        elif solids:
            centre, tensor = inertia_tensor(solids, masses_by_volume(solids, mass))
            _write_inertial(out, mass, (vector(centre), CENTRE[1]), tensor)
        else:
            _write_inertial(out, mass, CENTRE, 0.4 * mass * POINT_RADIUS**2 * np.eye(3))
        return mass

    def _given_tensor(self, name: str, inertial: Any) -> Array | None:
        """Return the given inertia tensor; None without one that a body can have."""
        element = inertial.find("inertia")
        if element is None:
            return None
        xx, yy, zz, xy, xz, yz = (
            read_numbers(element.get(key, "0"), f"{key} of link {name!r}", 1, xml.INERTIAS)[0]
            for key in xml.INERTIA
        )
        tensor = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        low, middle, high = np.linalg.eigvalsh(tensor).tolist()
        if low > SMALLEST * high and low + middle >= high * (1.0 - xml.ROUNDED):
            return tensor
        self._note(f"no body can have the inertia of link {name!r}: it is computed from mass and shapes")
        return None

    def _solids(self, out: Element, element: Any) -> Iterator[Part]:
        """Write a <collision>; yields its shapes."""
        place, angles = read_pose(element)
        orientation = quaternion(*angles)
        if element.find("geometry/plane") is not None:
            place = vector(np.add(place, rotated(orientation, (0.0, 0.0, -PLANE[2] / 2))))
        for shape, mesh in self._shapes_of(element, solid=True):
            assert shape is not None, "solid meshes have hulls"
            written = SubElement(out, "collision", {"concave": "yes"} if mesh is not None and mesh.concave else {})
            write_pose(written, place, angles)
            _write_geometry(written, shape, mesh)
            yield Part(shape, place, orientation)

    def _visual(self, out: Element, element: Any) -> None:
        own = self._colour or self._colour_of(element)
        for material in element.findall(f"material[@{SCRIPT}]"):
            self._note(f"without effect: the unknown material {material.get(SCRIPT)!r} of <script>")
        for shape, mesh in self._shapes_of(element, solid=False):
            written = SubElement(out, "visual")
            write_pose(written, *read_pose(element))
            _write_geometry(written, shape, mesh)
            colour = own or (None if mesh is None else mesh.colour)
            if colour is None:
                continue
            self._first_colour = self._first_colour or colour
            material = SubElement(written, "material", name=f"material{len(self._out)}_{len(out)}")
            if mesh is None or mesh.picture is None:
                SubElement(material, "color", rgba=text_of(colour))
            else:  # the colour of the file tints its picture
                SubElement(material, "color", rgba=text_of(own or WHITE))
                SubElement(material, "texture", filename=mesh.picture)

    def _colour_of(self, visual: Any) -> Colour | None:
        """Return the colour of the material of a <visual>."""
        colour = self._of_material(visual, "color")
        if colour is None:
            return None
        values = read_numbers(colour.get("rgba"), "rgba of <color>", None, (0.0, 1.0))
        if len(values) not in (3, 4):
            raise xml.invalid(f"invalid rgba of <color>: {colour.get('rgba')!r}; expected 4 numbers")
        red, green, blue, opacity = (*values, 1.0)[:4]
        return red, green, blue, opacity

    def _of_material(self, visual: Any, tag: str) -> Any:
        """Return an element of the material of a <visual>, its own or by name; None without one."""
        material = visual.find("material")
        own = None if material is None else material.find(tag)
        if own is not None or material is None or not material.get("name"):
            return own
        return self._materials.get((material.get("name"), tag))

    def _shapes_of(self, element: Any, *, solid: bool) -> Iterator[tuple[Shape | None, MeshFile | None]]:
        """Yield the shapes of a <collision> or <visual>; those of meshes with their files, None if not solid."""
        geometry = element.find("geometry")
        shape = None if geometry is None else next(iter(geometry), None)
        if shape is None:
            self._note(f"without effect: {xml.label(element)} without a shape")
            return
        named = None if solid else self._of_material(element, "texture")
        texture = None if named is None else virtual_path(named.get("filename") or "")
        if shape.tag == "mesh":
            if solid and self._is_static and shape.get(FIELD) == "true":
                field = self._mesh_files().write_field(shape)
                yield field.hull, field
                return
            for mesh in self._mesh_files().write(shape, xml.label(element), solid=solid, texture=texture):
                yield mesh.hull, mesh
            return
        found = Box(PLANE) if shape.tag == "plane" else read_shape(shape, xml.label(element))
        if volume(found) <= 0.0:
            self._note(f"without effect: {xml.label(element)} with a shape without extent")
            return
        pictured = None if texture is None else self._mesh_files().write_picture(found, texture)
        if texture is not None and isinstance(found, Capsule):
            self._note("without effect: <texture> of a <capsule>; expected a mesh, box, cylinder, sphere or plane")
        yield found, pictured

    def _mesh_files(self) -> MeshFiles:
        from sim_nodes.models.mesh_files import MeshFiles  # noqa: PLC0415 - robots without meshes start sooner

        if self._meshes is None:
            self._meshes = MeshFiles(self._files, self._settings, self._note)
        return self._meshes


def _given_mass(link: Any) -> float | None:
    """Return the mass of a link in its file [kg]."""
    element = link.find("inertial/mass")
    return (
        None if element is None else read_numbers(element.get("value"), f"mass of {xml.label(link)}", 1, MASSES)[0]
    )


def _is_world(root: Any) -> bool:
    """Whether a root link is that of the world, by the convention of ROS."""
    return root.get("name") == "world" and root.find("collision") is None and root.find("inertial") is None


def _write_inertial(out: Element, mass: float, pose: tuple[Vector, Vector], tensor: Array) -> None:
    inertial = SubElement(out, "inertial")
    write_pose(inertial, *pose)
    SubElement(inertial, "mass", value=repr(mass))
    values = zip(xml.INERTIA, tensor[[0, 1, 2, 0, 0, 1], [0, 1, 2, 1, 2, 2]].tolist(), strict=True)
    SubElement(inertial, "inertia", {key: repr(value) for key, value in values})


def _write_geometry(out: Element, shape: Shape | None, mesh: MeshFile | None) -> None:
    geometry = SubElement(out, "geometry")
    if mesh is not None:
        SubElement(geometry, "mesh", filename=mesh.name)
    elif shape is not None:
        write_shape(geometry, shape)

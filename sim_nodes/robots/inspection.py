"""Inspection of models and declarations of robots: links, joints, drive, sensors, and problems."""

from __future__ import annotations

from dataclasses import asdict
from pathlib import Path

from seoro.bridges.model_files import gather
from seoro.bridges.wire.refusal import RequestRefused
from seoro.deferred import dataclass
from sim_nodes.models import parse_model
from sim_nodes.models.xml_reading import parse_xml
from sim_nodes.physics import Urdf
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.derive.complete import Content, declared_form, long_form
from sim_nodes.robots.derive.mobile import derive_mobile
from sim_nodes.robots.derive.model import ModelJoint, RobotModel, read_model
from sim_nodes.robots.derive.wheels import find_wheels, guess_kind
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.reading import available_robots, load_robot, read_robot

DECLARATIONS = (".yaml", ".yml")


@dataclass(frozen=True)
class InspectedLink:
    """A link: its mass [kg], and the number of its solid shapes."""

    name: str
    mass: float
    solids: int


@dataclass(frozen=True)
class Inspection:
    """A robot, by its model or declaration.

    Attributes:
        name: Its name.
        path: Path of its model or declaration, or the name of a robot.
        root: Root link.
        mass: Mass [kg].
        links: Links, in the order of the file.
        joints: Joints, in the order of the file.
        drive: Kind of drive; None without wheels.
        is_derived: Whether the declaration is derived from the model.
        declaration: Content of the long declaration; empty without a drive.
        notes: Changes of the model, and parts without effect.
        problems: Reasons for which a declaration cannot be derived.
    """

    name: str
    path: str
    root: str
    mass: float
    links: tuple[InspectedLink, ...]
    joints: tuple[ModelJoint, ...]
    drive: str | None
    is_derived: bool
    declaration: Content
    notes: tuple[str, ...]
    problems: tuple[str, ...]

    def as_dict(self) -> dict[str, object]:
        """Convert to values of JSON; infinite limits are null."""
        joints = [
            {key: None if value in (INFINITE, -INFINITE) else value for key, value in asdict(joint).items()}
            for joint in self.joints
        ]
        return {**asdict(self), "joints": joints, "declaration": dict(self.declaration)}


INFINITE = float("inf")


def inspect(subject: str, drive: DriveKind | None = None) -> Inspection:
    """Inspect a robot.

    Args:
        subject: Name of a robot, or path of a declaration or a model.
        drive: Kind of drive to derive for a model; None to guess it from the wheels.

    Raises:
        FileError: The declaration is invalid.
        InvalidModel: The model cannot be read.
        RequestRefused: The model is invalid.
    """
    if subject in available_robots():
        return _declared(subject, load_robot(subject))
    if Path(subject).suffix.lower() in DECLARATIONS:
        return _declared(subject, read_robot(Path(subject)))
    return _derived(subject, drive)


def _declared(subject: str, declaration: RobotDeclaration) -> Inspection:
    model = read_model(Urdf(declaration.urdf, dict(declaration.meshes), (), {}))
    mobile = declaration.mobile
    return _inspection(
        declaration.model,
        subject,
        model,
        drive=None if mobile is None else mobile.drive.kind.value,
        is_derived=False,
        declaration=declared_form(declaration),
        notes=declaration.notes,
    )


def _derived(subject: str, drive: DriveKind | None) -> Inspection:
    found = gather(Path(subject), expands=True)
    body = parse_model(found.text, found.files)
    assert body.urdf is not None
    model, source = read_model(body.urdf), parse_xml(found.text)
    kind = drive or guess_kind(find_wheels(model))
    name = str(source.get("name") or Path(subject).stem)
    if kind is None:
        return _inspection(name, subject, model, notes=body.notes)
    try:
        robot = derive_mobile(model, kind, source)
    except RequestRefused as error:
        return _inspection(name, subject, model, drive=kind.value, notes=body.notes, problems=(error.message,))
    return _inspection(
        name,
        subject,
        model,
        drive=robot.mobile.drive.kind.value,
        declaration=long_form(robot),
        notes=(*body.notes, *robot.notes),
    )


def _inspection(
    name: str,
    path: str,
    model: RobotModel,
    *,
    drive: str | None = None,
    is_derived: bool = True,
    declaration: Content | None = None,
    notes: tuple[str, ...] = (),
    problems: tuple[str, ...] = (),
) -> Inspection:
    links = tuple(InspectedLink(link, model.masses[link], len(model.solids[link])) for link in model.frames)
    joints = tuple(model.joints.values())
    content = declaration or {}
    return Inspection(
        name, path, model.root, model.mass, links, joints, drive, is_derived, content, notes, problems
    )

"""Completes short declarations: those with `drive`, whose other values come from the model."""

from __future__ import annotations

import math
from collections.abc import Mapping
from types import MappingProxyType
from typing import Any

from defusedxml import ElementTree

from seoro.bridges.wire.refusal import name_list
from sim_nodes.models import xml_reading as xml
from sim_nodes.physics import Urdf
from sim_nodes.robots.declaration import ArmDeclaration, MobileDeclaration, RobotDeclaration
from sim_nodes.robots.derive.jointed import (
    FRICTION,
    DerivedJoints,
    JointDrive,
    complete_limits,
    derive_jointed,
    derive_joints,
)
from sim_nodes.robots.derive.jointed import KINDS as KINDS_OF_JOINTED
from sim_nodes.robots.derive.keyframes import Keyframes
from sim_nodes.robots.derive.mobile import BODY_FRICTION, KINDS, KINDS_WITH_ARM, DerivedRobot, derive_mobile
from sim_nodes.robots.derive.model import RobotModel, read_model
from sim_nodes.robots.derive.mounting import mount, read_mounting
from sim_nodes.robots.derive.rewriting import source_text, urdf_text
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.postures import postures_form

MOBILE_DRIVES = tuple(kind.value for kind in DriveKind)
JOINT_DRIVES = tuple(kind.value for kind in JointDrive)
SHORT = frozenset({"drive", "urdf", "notes"})
"""Keys of short declarations that derived content replaces."""
Content = Mapping[str, object]


NO_KEYFRAMES: Mapping[str, Mapping[str, float]] = MappingProxyType({})


def complete(
    content: Content,
    urdf: Urdf,
    text: str,
    carried: RobotDeclaration | None = None,
    keyframes: Mapping[str, Mapping[str, float]] = NO_KEYFRAMES,
) -> dict[str, object]:
    """Return the long form of a short declaration; its own values replace derived ones.

    Args:
        content: Content of the declaration.
        urdf: Canonical URDF of its model.
        text: Text of the model's file.
        carried: Robot that is `mounted` on it.
        keyframes: Positions by joint in its file [rad], [m], by name; see `Keyframes`.

    Raises:
        RequestRefused: The drive is unknown, or the model does not fit it.
    """
    drive = content["drive"]
    root = xml.parse_xml(text)
    if drive in JOINT_DRIVES:
        return _complete_joints(content, urdf, text if root.tag == "robot" else None, Keyframes(keyframes))
    if drive not in MOBILE_DRIVES:
        raise xml.invalid(f"unknown `drive` {drive!r}; expected {name_list((*MOBILE_DRIVES, *JOINT_DRIVES))}")
    kind = DriveKind(str(drive))
    if carried is not None:
        return _complete_mounted(content, kind, urdf, root, carried)
    model = read_model(urdf)
    known = Keyframes(keyframes)
    arm = None if "arm" not in content else _joints_of(model, JointDrive.ARM, content, known.home)
    robot = derive_mobile(model, kind, root, None if arm is None else arm.arm)
    source = source_text(text, robot.changes) if root.tag == "robot" else robot.urdf.text
    derived = {**long_form(robot), "source": source, "urdf": robot.urdf.text}
    if arm is None:
        return _with_own(derived, robot.notes, content, SHORT)
    completed: Any = ElementTree.fromstring(robot.urdf.text)
    notes = (*robot.notes, *complete_limits(completed, arm))
    derived |= {**_carrying(arm.arm), "urdf": urdf_text(completed), "postures": known.postures(arm)}
    return _with_own(derived, notes, content, SHORT | {"home"})


def _complete_mounted(
    content: Content, kind: DriveKind, urdf: Urdf, source: Any, carried: RobotDeclaration
) -> dict[str, object]:
    """Return the long form of a base that carries another robot."""
    both = mount(urdf, carried, read_mounting(content), _home_of(content))
    robot = derive_mobile(read_model(both.urdf), kind, source, both.arm)
    derived = {**long_form(robot), **_carrying(both.arm), "source": robot.urdf.text, "urdf": robot.urdf.text}
    for key, parts in (("cameras", both.cameras), ("sensors", both.sensors)):
        own = derived.get(key, [])
        derived[key] = [*(own if isinstance(own, list) else []), *(part.model_dump(mode="json") for part in parts)]
    derived["meshes"] = tuple(both.urdf.meshes.items())
    derived["postures"] = postures_form(both.postures)
    return _with_own(derived, (*robot.notes, *carried.notes), content, SHORT | {"home", "mounted", "meshes"})


def _carrying(arm: ArmDeclaration) -> dict[str, object]:
    """Return the content of a base that carries an arm."""
    return {"kinds": list(KINDS_WITH_ARM), "arm": arm.model_dump(mode="json", exclude_none=True)}


def _joints_of(
    model: RobotModel, drive: JointDrive, content: Content, usual: Mapping[str, float]
) -> DerivedJoints:
    """Derive the joints of a model, by the `home` and the tool of a declaration, or its usual positions."""
    return derive_joints(model, drive, _home_of(content), _tool_of(content), usual)


def _tool_of(content: Content) -> str | None:
    """Return the name of the tool in a short declaration, if any."""
    arm = content.get("arm")
    tool = arm.get("tool_link") if isinstance(arm, Mapping) else None
    return None if tool is None else str(tool)


def _complete_joints(content: Content, urdf: Urdf, text: str | None, keyframes: Keyframes) -> dict[str, object]:
    """Return the long form of an arm, or of a body that moves by its joints."""
    drive, model = JointDrive(str(content["drive"])), read_model(urdf)
    joints = _joints_of(model, drive, content, keyframes.home)
    robot = derive_jointed(model, drive, joints)
    derived: dict[str, object] = {
        "kinds": list(KINDS_OF_JOINTED[drive]),
        "base_link": robot.base_link,
        "fixed": drive is JointDrive.ARM,
        "standing_height": robot.standing_height,
        "body_friction": FRICTION[drive],
        "arm": robot.arm.model_dump(mode="json", exclude_none=True),
        "postures": keyframes.postures(joints),
        "source": robot.urdf if text is None else text,
        "urdf": robot.urdf,
    }
    return _with_own(derived, robot.notes, content, SHORT | {"home"})


def _with_own(
    derived: Content, notes: tuple[str, ...], content: Content, short: frozenset[str]
) -> dict[str, object]:
    """Return derived content with notes and the own values of a declaration, except keys of its short form."""
    known = content.get("notes")
    all_notes = (*(known if isinstance(known, tuple) else ()), *notes)
    own = {key: value for key, value in content.items() if key not in short}
    return merged({**derived, "notes": all_notes}, own)


def _home_of(content: Content) -> dict[str, float]:
    """Return the initial positions in a short declaration by joint or pattern [rad]."""
    home = content.get("home", {})
    if not isinstance(home, Mapping) or not all(
        isinstance(value, int | float) and math.isfinite(value) for value in home.values()
    ):
        raise xml.invalid(f"invalid `home` {home!r}; expected positions [rad] by joint, such as {{elbow: 1.5}}")
    return {str(name): float(value) for name, value in home.items()}


def long_form(robot: DerivedRobot) -> dict[str, object]:
    """Return a derived declaration as the content of a file, without defaults and the files of the model."""
    content: dict[str, object] = {
        "kinds": list(KINDS),
        "base_link": robot.base_link,
        "body_friction": BODY_FRICTION,
        "low_friction_links": list(robot.low_friction_links),
        "mobile": _mobile_form(robot.mobile),
        "cameras": [camera.model_dump(mode="json", exclude_defaults=True) for camera in robot.cameras],
    }
    return {key: value for key, value in content.items() if value != []}


def declared_form(declaration: RobotDeclaration) -> dict[str, object]:
    """Return a declaration as the content of a file, without defaults and the files of the model."""
    files = {"source", "urdf", "meshes", "native", "notes", "model"}
    content = declaration.model_dump(mode="json", exclude_defaults=True, exclude=files)
    if declaration.mobile is not None:
        content["mobile"] = _mobile_form(declaration.mobile)
    return content


def _mobile_form(mobile: MobileDeclaration) -> dict[str, object]:
    content: dict[str, object] = mobile.model_dump(mode="json", exclude_defaults=True)
    drive = mobile.drive.model_dump(mode="json", exclude_defaults=True)
    content["drive"] = {"kind": mobile.drive.kind.value} | drive
    if mobile.footprint is not None:
        content["footprint"] = [list(corner) for corner in mobile.footprint.corners]
    return content


def merged(derived: Content, own: Content) -> dict[str, object]:
    """Return derived content with own values, key by key; lists are replaced as a whole."""
    result = dict(derived)
    for key, value in own.items():
        known = result.get(key)
        if isinstance(known, Mapping) and isinstance(value, Mapping) and _is_alike(known, value):
            result[key] = merged(known, value)
        else:
            result[key] = value
    return result


def _is_alike(derived: Content, own: Content) -> bool:
    """Whether values are of the same kind; a drive of another kind replaces the derived one as a whole."""
    return own.get("kind", derived.get("kind")) == derived.get("kind")

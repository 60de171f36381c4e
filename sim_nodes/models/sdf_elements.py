"""Elements of SDF (http://sdformat.org): models of a file, names, poses and Boolean values."""

from __future__ import annotations

import math
import posixpath
from collections.abc import Mapping
from typing import Any

from seoro.bridges.model_files import virtual_path
from seoro.deferred import dataclass
from sim_nodes.geometry import Frame, quaternion
from sim_nodes.models import xml_reading as xml


@dataclass(frozen=True)
class SdfModel:
    """A model of an SDF file.

    Attributes:
        name: Its name in the file.
        element: Its element.
        pose: Its pose in the file.
        folder: Virtual folder of its own file.
        static: Whether it is static.
    """

    name: str
    element: Any
    pose: Frame
    folder: str
    static: bool


def models_of(root: Any, files: Mapping[str, bytes]) -> list[SdfModel]:
    """Return the models of an SDF file and of its includes.

    Args:
        root: Root element.
        files: Files of the model by virtual path.

    Raises:
        RequestRefused: A model is missing or invalid.
    """
    found = []
    for holder in (root, *root.findall("world")):
        for model in holder.findall("model"):
            is_static = is_true(model.find("static"))
            found.append(SdfModel(name_of(model), model, pose_of(model), "", is_static))
        for include in holder.findall("include"):
            inner, folder = included_model(include, files, "")
            name = (include.findtext("name") or "").strip() or name_of(inner)
            posed = inner if include.find("pose") is None else include
            is_static = any(is_true(each.find("static")) for each in (inner, include))
            found.append(SdfModel(name, inner, pose_of(posed), folder, is_static))
    return found


def included_model(include: Any, files: Mapping[str, bytes], folder: str) -> tuple[Any, str]:
    """Return the model that an <include> names, and the virtual folder of its file."""
    uri = (include.findtext("uri") or "").strip()
    inside = virtual_path(uri, folder)
    for path in (inside, f"{inside}/{_config(files, inside)}", f"{inside}/model.sdf"):
        if path in files:
            models = xml.parse_xml(files[path].decode("utf-8", "replace")).findall("model")
            if len(models) != 1:
                raise xml.invalid(f"found {len(models)} models in the included {uri!r}; expected one")
            return models[0], posixpath.dirname(path)
    raise xml.invalid(f"missing model {uri!r} of <include>; expected it among the files of the model")


def _config(files: Mapping[str, bytes], folder: str) -> str:
    """Return the name of the model file that a `model.config` names last: that of the newest version."""
    config = files.get(f"{folder}/model.config")
    found = [] if config is None else xml.parse_xml(config.decode("utf-8", "replace")).findall("sdf")
    return (found[-1].text or "").strip() if found else ""


def name_of(element: Any) -> str:
    """Return the name of an element, which must have one."""
    name = element.get("name")
    if not name:
        raise xml.invalid(f"missing name of a <{element.tag}>")
    return str(name)


def pose_of(element: Any) -> Frame:
    """Return the frame that the <pose> of an element gives, or the identity."""
    pose = element.find("pose")
    return xml.ORIGIN if pose is None else _read_pose(pose)


def _read_pose(pose: Any) -> Frame:
    """Read a <pose>: x, y, z [m], and roll, pitch and yaw, or a quaternion x, y, z, w."""
    text = (pose.text or "").strip() or "0 0 0 0 0 0"
    if pose.get("rotation_format", "euler_rpy") == "quat_xyzw":
        x, y, z, i, j, k, w = xml.numbers(text, "<pose>", 7, xml.PLACES)
        norm = math.hypot(w, i, j, k)
        if not norm:
            raise xml.invalid("zero length: quaternion of <pose>")
        return (x, y, z), (w / norm, i / norm, j / norm, k / norm)
    x, y, z, *angles = xml.numbers(text, "<pose>", 6, xml.PLACES)
    scale = math.pi / 180.0 if pose.get("degrees") in ("true", "1") else 1.0
    roll, pitch, yaw = (angle * scale for angle in angles)
    return (x, y, z), quaternion(roll, pitch, yaw)


def is_true(element: Any) -> bool:
    """Whether a Boolean element is set; a missing one is not."""
    text = "false" if element is None else (element.text or "").strip()
    if text not in ("true", "false", "1", "0"):
        raise xml.invalid(f"invalid <{element.tag}>: {text!r}; expected true or false")
    return text in ("true", "1")

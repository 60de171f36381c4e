"""Props of a world: bodies that belong to it from the start."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from seoro.bridges.wire.refusal import RequestRefused
from seoro.files.yaml_lines import FileError, read_text
from sim_nodes.extents import FLOOR_TOLERANCE, lowest_point
from sim_nodes.geometry import quaternion
from sim_nodes.models import parse_model
from sim_nodes.physics import BodyModel, BodyState, Box, Cylinder, Part, Shape, Sphere
from sim_nodes.worlds.schema import PropFile


@dataclass(frozen=True)
class Prop:
    """A body of a world, and its initial state."""

    name: str
    model: BodyModel
    state: BodyState


def read_prop(prop: PropFile, index: int, folder: Path) -> Prop:
    """Read a prop of a world file.

    Args:
        prop: Entry of the file.
        index: Index of the entry, from 0.
        folder: Folder that relative file names start from.

    Raises:
        FileError: Its model is unreadable or invalid, or the prop would be below the floor.
    """
    model = _model(prop, index, folder)
    pose = prop.pose
    state = BodyState((pose.x, pose.y, 0.0), quaternion(pose.roll, pose.pitch, pose.yaw))
    needed = -lowest_point(model, state)
    z = needed if pose.z is None else pose.z
    if z < needed - FLOOR_TOLERANCE:
        raise FileError(
            f"props.{index}.pose.z: {prop.name!r} would be {needed - z:.3f} m below the floor; "
            f"expected z of {needed:.3f} m or more, or none"
        )
    return Prop(prop.name, model, replace(state, position=(pose.x, pose.y, z)))


def _model(prop: PropFile, index: int, folder: Path) -> BodyModel:
    colour = None if prop.colour is None else (*prop.colour, 1.0)
    if prop.model is None:
        parts = (Part(_shape(prop)),)
        static = prop.mass is None
        return BodyModel(parts, prop.mass or 1.0, prop.friction, static=static, colour=colour)
    try:
        model = parse_model(read_text(folder / prop.model), static=prop.static)
    except FileError as error:
        raise FileError(f"props.{index}.model: {error}") from error
    except RequestRefused as error:
        raise FileError(f"props.{index}.model: {prop.model}: {error.message}") from error
    return model if colour is None else replace(model, colour=colour)


def _shape(prop: PropFile) -> Shape:
    if prop.box is not None:
        return Box(prop.box)
    if prop.cube is not None:
        return Box((prop.cube, prop.cube, prop.cube))
    if prop.cylinder is not None:
        return Cylinder(prop.cylinder.radius, prop.cylinder.length)
    assert prop.sphere is not None, "the schema requires one form"
    return Sphere(prop.sphere)

"""Scenes of traces as Foxglove's `SceneUpdate` and `Grid`."""

from __future__ import annotations

import zlib
from base64 import b64decode
from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from foxglove.messages import (
    CubePrimitive,
    CylinderPrimitive,
    Grid,
    PackedElementField,
    PackedElementFieldNumericType,
    Point3,
    Pose,
    Quaternion,
    SceneEntity,
    SceneEntityDeletion,
    SceneUpdate,
    SpherePrimitive,
    TextPrimitive,
    Timestamp,
    TriangleListPrimitive,
    Vector2,
    Vector3,
)

from seoro.traces.foxglove.values import GREY, relative_pose, to_color, to_pose

MAP = "map"
MAX_CELLS = 100_000_000  # of a map
UPRIGHT = Quaternion(x=0.0, y=0.0, z=0.0, w=1.0)

Fields = Mapping[str, Any]


def scene_update(scene: Fields, time: Timestamp) -> SceneUpdate:
    """Convert a scene: walls and static objects in `map`, and entities in frames of their names."""
    static: dict[str, list[Fields]] = defaultdict(list)
    for shape in scene["shapes"]:
        static[shape.get("entity", "")].append(shape)
    entities = [_entity(name, MAP, shapes, time) for name, shapes in static.items()]
    entities += [found for each in scene["entities"] for found in _entities(each, time)]
    return SceneUpdate(entities=entities)


def entity_update(entity: Fields, time: Timestamp) -> SceneUpdate:
    """Convert an entity that was spawned."""
    return SceneUpdate(entities=list(_entities(entity, time)))


def removal_update(names: Sequence[str], time: Timestamp) -> SceneUpdate:
    """Convert deletions of entities."""
    return SceneUpdate(deletions=[SceneEntityDeletion(timestamp=time, id=name) for name in names])


def grid_of(known: Fields, time: Timestamp) -> Grid:
    """Convert the map of a scene, one byte per cell: 0 free, 100 occupied, 255 unknown.

    Raises:
        ValueError: The map is invalid.
    """
    width, height = int(known["width"]), int(known["height"])
    if not 0 < width * height <= MAX_CELLS:
        raise ValueError(f"invalid size of a map: {width} x {height} cells")
    cells = zlib.decompressobj().decompress(b64decode(known["data"]), width * height + 1)
    if len(cells) != width * height:
        raise ValueError(f"the map has {len(cells)} cells; expected {width * height}")
    x, y, _ = known["origin"]
    edge = known["resolution"]
    return Grid(
        timestamp=time,
        frame_id=MAP,
        pose=Pose(position=Vector3(x=x, y=y, z=0.0), orientation=UPRIGHT),
        column_count=width,
        cell_size=Vector2(x=edge, y=edge),
        row_stride=width,
        cell_stride=1,
        fields=[PackedElementField(name="occupancy", offset=0, type=PackedElementFieldNumericType.Uint8)],
        data=cells,
    )


def link_frame(robot: str, link: str) -> str:
    """Return the frame of a link of a robot."""
    return f"{robot}/{link}"


def _entities(entity: Fields, time: Timestamp) -> Iterator[SceneEntity]:
    """Yield an entity, and its links that move, each with its shapes in its own frame."""
    name, links = entity["name"], entity.get("links", {})
    own = [shape for shape in entity["shapes"] if shape.get("link") not in links]
    yield _entity(name, name, own, time, is_lost=entity.get("frame", MAP) != MAP)
    for link, frame in links.items():
        shapes = [
            {**shape, "pose": relative_pose(frame, shape["pose"])}
            for shape in entity["shapes"]
            if shape.get("link") == link
        ]
        yield _entity(link_frame(name, link), link_frame(name, link), shapes, time)


def _entity(
    name: str, frame: str, shapes: Sequence[Fields], time: Timestamp, *, is_lost: bool = False
) -> SceneEntity:
    """Convert an entity; `is_lost` adds a text, since its pose in the map is unknown."""
    texts = [_label(f"{name}, by odometry")] if is_lost else []
    found = [primitive for shape in shapes for primitive in _primitives(shape)]
    return SceneEntity(
        timestamp=time,
        frame_id=frame,
        id=name,
        frame_locked=True,
        cubes=[each for each in found if isinstance(each, CubePrimitive)],
        spheres=[each for each in found if isinstance(each, SpherePrimitive)],
        cylinders=[each for each in found if isinstance(each, CylinderPrimitive)],
        triangles=[each for each in found if isinstance(each, TriangleListPrimitive)],
        texts=texts,
    )


def _label(text: str) -> TextPrimitive:
    place = Pose(position=Vector3(x=0.0, y=0.0, z=0.5), orientation=UPRIGHT)
    grey = to_color(GREY)
    return TextPrimitive(pose=place, billboard=True, font_size=14.0, scale_invariant=True, color=grey, text=text)


Primitive = CubePrimitive | SpherePrimitive | CylinderPrimitive | TriangleListPrimitive


def _primitives(shape: Fields) -> Iterator[Primitive]:
    """Yield the primitives of a shape; none for unknown kinds."""
    pose, color, size = to_pose(shape["pose"]), to_color(shape.get("color", GREY)), shape["size"]
    match shape["kind"]:
        case "box":
            x, y, z = size
            yield CubePrimitive(pose=pose, size=Vector3(x=x, y=y, z=z), color=color)
        case "sphere":
            yield SpherePrimitive(pose=pose, size=_ball(size[0]), color=color)
        case "cylinder" | "capsule":
            radius, length = size
            across = Vector3(x=2 * radius, y=2 * radius, z=length)
            yield CylinderPrimitive(pose=pose, size=across, bottom_scale=1.0, top_scale=1.0, color=color)
            if shape["kind"] == "capsule":
                for end in (-0.5, 0.5):
                    place = _along(shape["pose"], end * length)
                    yield SpherePrimitive(pose=to_pose(place), size=_ball(radius), color=color)
        case "hull":
            corners = [Point3(x=x, y=y, z=z) for x, y, z in shape["corners"]]
            points = [corners[index] for triangle in shape["triangles"] for index in triangle]
            yield TriangleListPrimitive(pose=pose, points=points, color=color)
        case "polygon":
            points = _prism(shape["points"], size[0])
            yield TriangleListPrimitive(pose=pose, points=points, color=color)


def _ball(radius: float) -> Vector3:
    return Vector3(x=2 * radius, y=2 * radius, z=2 * radius)


def _along(pose: Sequence[float], distance: float) -> list[float]:
    """Return a pose moved along its own z axis [m]."""
    px, py, pz, x, y, z, w = pose
    axis = (2 * (x * z + w * y), 2 * (y * z - w * x), 1 - 2 * (x * x + y * y))
    return [px + distance * axis[0], py + distance * axis[1], pz + distance * axis[2], x, y, z, w]


def _prism(corners: Sequence[Sequence[float]], height: float) -> list[Point3]:
    """Return the triangles of an upright prism around its centre, for a convex outline."""
    low = [Point3(x=x, y=y, z=-height / 2) for x, y in corners]
    top = [Point3(x=x, y=y, z=height / 2) for x, y in corners]
    triangles: list[Point3] = []
    for at in range(1, len(corners) - 1):
        triangles += (top[0], top[at], top[at + 1], low[0], low[at + 1], low[at])
    for at in range(len(corners)):
        after = (at + 1) % len(corners)
        triangles += (low[at], low[after], top[after], low[at], top[after], top[at])
    return triangles

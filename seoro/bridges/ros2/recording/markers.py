"""Shapes of a trace as `visualization_msgs/msg/Marker`."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, Final

from seoro.bridges.ros2.recording.bag_values import MAP, Values, pose_value, stamped, vector
from seoro.robotics.transform import Transform

Fields = Mapping[str, Any]
Point = Sequence[float]

_CUBE, _SPHERE, _CYLINDER, _TEXT, _TRIANGLES = 1, 2, 3, 9, 11  # kinds of markers
DELETE: Final = 2  # action of a marker
_GREY: Final = "#808080"
_UNIT: Final = (1.0, 1.0, 1.0)
_TEXT_HEIGHT: Final = 0.15  # [m] of a capital letter
_ABOVE: Final = (0.0, 0.0, 0.5, 0.0, 0.0, 0.0, 1.0)  # pose of a text
WORLD: Final = "world"


def markers_of(entity: Fields, at: int) -> Iterator[Values]:
    """Yield the markers of an entity in its frame and those of its moving links; those of the world in `map`.

    Args:
        entity: Entity of a record; the shapes of the world have the name `world`.
        at: Time since the epoch [ns].
    """
    name, links = entity["name"], entity.get("links", {})
    number = 0
    for shape in entity.get("shapes", ()):
        frame, pose = (MAP if name == WORLD else name), shape["pose"]
        if (link := shape.get("link")) in links:
            frame, pose = link_frame(name, link), _relative(links[link], pose)
        for part in _parts(shape, pose):
            yield _marker(name, number, frame, at) | part
            number += 1
    if entity.get("frame", MAP) != MAP:
        shown = {"pose": pose_value(_ABOVE), "scale": vector(0, 0, _TEXT_HEIGHT), "color": _color(_GREY)}
        text = {"type": _TEXT, "text": f"{name}, by odometry"}
        yield _marker(name, number, name, at) | text | shown


def deletion(name: str, number: int, at: int) -> Values:
    """Return the message that deletes a marker of an entity."""
    return _marker(name, number, MAP, at) | {"action": DELETE}


def link_frame(robot: str, link: str) -> str:
    """Return the frame of a link of a robot."""
    return f"{robot}/{link}"


def _marker(name: str, number: int, frame: str, at: int) -> Values:
    return stamped(at, frame) | {"ns": name, "id": number, "frame_locked": frame != MAP}


def _parts(shape: Fields, pose: Point) -> Iterator[Values]:
    """Yield the fields of the markers of a shape; none for unknown kinds."""
    size, color = shape["size"], _color(shape.get("color", _GREY))

    def part(kind: int, place: Point, scale: Point) -> Values:
        return {"type": kind, "pose": pose_value(place), "scale": vector(*scale), "color": color}

    match shape["kind"]:
        case "box":
            yield part(_CUBE, pose, size)
        case "sphere":
            yield part(_SPHERE, pose, (2 * size[0],) * 3)
        case "cylinder" | "capsule":
            radius, length = size
            yield part(_CYLINDER, pose, (2 * radius, 2 * radius, length))
            if shape["kind"] == "capsule":
                for end in (-0.5, 0.5):
                    place = _transform(pose).apply((0.0, 0.0, end * length))
                    yield part(_SPHERE, (*place, *pose[3:]), (2 * radius,) * 3)
        case "hull":
            corners = shape["corners"]
            points = [corners[index] for triangle in shape["triangles"] for index in triangle]
            yield part(_TRIANGLES, pose, _UNIT) | {"points": [vector(*point) for point in points]}
        case "polygon":
            points = list(_prism(shape["points"], size[0]))
            yield part(_TRIANGLES, pose, _UNIT) | {"points": [vector(*point) for point in points]}


def _prism(corners: Sequence[Point], height: float) -> Iterator[Point]:
    """Yield the triangles of an upright prism around its centre, for a convex outline."""
    low = [(x, y, -height / 2) for x, y in corners]
    top = [(x, y, height / 2) for x, y in corners]
    for at in range(1, len(corners) - 1):
        yield from (top[0], top[at], top[at + 1], low[0], low[at + 1], low[at])
    for at in range(len(corners)):
        after = (at + 1) % len(corners)
        yield from (low[at], low[after], top[after], low[at], top[after], top[at])


def _color(text: str) -> Values:
    parts = [int(text[place : place + 2], 16) / 255 for place in (1, 3, 5)]
    return dict(zip("rgba", (*parts, 1.0), strict=True))


def _relative(frame: Point, pose: Point) -> Point:
    """Return a pose in a frame; both are in the same parent frame."""
    found = _transform(frame).inverse() @ _transform(pose)
    return (*found.translation, *found.rotation)


def _transform(pose: Point) -> Transform:
    x, y, z, qx, qy, qz, qw = pose
    return Transform((x, y, z), (qx, qy, qz, qw))

"""Description of a simulated world, to draw it: see `wire.Scene`. Shapes are those of collisions."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from itertools import islice

from seoro.bridges import wire
from sim_nodes.bodies import BodyModel, BodyState, Box, Capsule, Cylinder, Hull, Part, Sphere
from sim_nodes.entities import Entities
from sim_nodes.extents import highest_of, lowest_of, outline
from sim_nodes.geometry import Pose2, quaternion
from sim_nodes.navigation.maps import NavigationMap
from sim_nodes.physics import FLOOR, Engine, PlacedRobot
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.moving_links import link_in_base, moving_links, parts_by_link
from sim_nodes.simple_hulls import simplified
from sim_nodes.views import TERRAIN, WALL, Colour, colour_of
from sim_nodes.worlds.loader import World

DIGITS = 4  # after the decimal point of numbers
MAX_CELLS = 4_000_000  # of a map that is described
AT_ORIGIN = BodyState((0.0, 0.0, 0.0))
OCCUPIED = 100  # occupied cell of nav_msgs/OccupancyGrid
CORNERS = 24  # of a round outline
ROBOT_COLOUR: Colour = (0.25, 0.27, 0.30, 1.0)


def describe_scene(
    time: float, world: World, engine: Engine, entities: Entities, known: NavigationMap
) -> wire.Scene:
    """Describe a world and the present entities.

    Args:
        time: Present time [s].
        world: The world.
        engine: Engine with the present states.
        entities: Entities of the world.
        known: Map of the world.
    """
    shapes = list(islice(_static_shapes(world, engine, entities), wire.MAX_SHAPES + 1))
    robots = [describe_robot(engine, robot) for robot in world.robots]
    objects = [describe_body(entities, name) for name in entities.movable()]
    found, left = [], wire.MAX_SHAPES - len(shapes)
    for entity in (*robots, *objects):
        found.append(entity if len(entity.shapes) <= left else entity.model_copy(update={"shapes": ()}))
        left -= len(found[-1].shapes)
    kept = shapes[: wire.MAX_SHAPES]
    described = sum(len(entity.shapes) for entity in found)
    return wire.Scene(
        time=time,
        world=world.name,
        simulator=engine.name,
        extent=world.extent,
        shapes=tuple(kept),
        entities=tuple(found),
        map=None if known.grid.columns * known.grid.rows > MAX_CELLS else describe_map(known),
        places=tuple(wire.ScenePlace(name=pose.name, pose=_planar(pose.place.planar)) for pose in world.poses),
        omitted=sum(len(entity.shapes) for entity in (*robots, *objects))
        - described
        + len(shapes)
        - len(kept)
        + len(world.ground.fields),
    )


def describe_robot(engine: Engine, robot: PlacedRobot) -> wire.SceneEntity:
    """Describe a robot in its present posture."""
    base = engine.body_state(robot.name)
    parts = list(parts_by_link(engine, robot, base))
    moving = moving_links(robot.declaration)
    shapes = [(link, describe_part(part, ROBOT_COLOUR)) for link, part in parts]
    return wire.SceneEntity(
        name=robot.name,
        kind="robot",
        model=robot.declaration.model,
        footprint=_footprint(robot.declaration.mobile),
        height=_height(part for _, part in parts),
        shapes=tuple(
            shape.model_copy(update={"link": link}) if link in moving else shape for link, shape in shapes
        ),
        links=tuple(
            wire.SceneLink(name=link, pose=link_values(engine, robot.name, link, base)) for link in moving
        ),
    )


def link_values(engine: Engine, robot: str, link: str, base: BodyState) -> tuple[float, ...]:
    """Return the pose of a link in the frame of its robot, as messages have it."""
    (x, y, z), (qw, qx, qy, qz) = link_in_base(engine, robot, link, base)
    return tuple(map(_rounded, (x, y, z, qx, qy, qz, qw)))


def _footprint(mobile: MobileDeclaration | None) -> tuple[tuple[float, float], ...]:
    """Return the corners of the outline of a robot on the floor [m]; none for robots that do not drive."""
    if mobile is None:
        return ()
    if mobile.footprint is not None:
        return mobile.footprint.corners
    angles = [2.0 * math.pi * index / CORNERS for index in range(CORNERS)]
    return tuple((_rounded(mobile.radius * math.cos(a)), _rounded(mobile.radius * math.sin(a))) for a in angles)


def describe_body(entities: Entities, name: str) -> wire.SceneEntity:
    """Describe a movable body: an object, a person or cart, a door or lift."""
    model = entities.bodies[name]
    agent = entities.agents.get(name)
    kind = "person" if agent is not None and agent.is_person else "door" if name in entities.built_in else "object"
    colour = colour_of(name, model.colour)
    return wire.SceneEntity(
        name=name,
        kind=kind,
        height=_height(model.parts),
        shapes=tuple(describe_part(part, colour) for part in model.parts),
    )


def describe_part(part: Part, colour: Colour, entity: str = "") -> wire.SceneShape:
    """Describe a shape; a hull has fewer corners than its part, and a flat one becomes an upright prism."""
    w, x, y, z = part.orientation
    pose = (*part.position, x, y, z, w)
    points: tuple[tuple[float, float], ...] = ()
    corners = triangles = b""
    sizes: tuple[float, ...] = ()
    match part.shape:
        case Box(size=size):
            kind, sizes = "box", tuple(size)
        case Sphere(radius=radius):
            kind, sizes = "sphere", (radius,)
        case Cylinder(radius=radius, length=length):
            kind, sizes = "cylinder", (radius, length)
        case Capsule(radius=radius, length=length):
            kind, sizes = "capsule", (radius, length)
        case Hull() if (hull := simplified(part.shape)) is not None:
            kind = "hull"
            corners, triangles = hull.corners.astype("<f4").tobytes(), hull.triangles.tobytes()
        case _:
            low, high = lowest_of(part, AT_ORIGIN), highest_of(part, AT_ORIGIN)
            kind, sizes = "polygon", (high - low,)
            pose = (0.0, 0.0, (low + high) / 2, 0.0, 0.0, 0.0, 1.0)
            points = tuple((_rounded(px), _rounded(py)) for px, py in outline(part, AT_ORIGIN).tolist())
    return wire.SceneShape(
        kind=kind,
        pose=tuple(map(_rounded, pose)),
        size=tuple(map(_rounded, sizes)),
        points=points,
        corners=corners,
        triangles=triangles,
        color="#" + "".join(f"{round(255 * share):02x}" for share in colour[:3]),
        entity=entity,
    )


def describe_map(known: NavigationMap) -> wire.OccupancyGrid:
    """Describe the cells of a map."""
    grid = known.grid
    occupied = (known.distance <= grid.resolution / 2.0).astype("u1") * OCCUPIED
    return wire.OccupancyGrid(
        resolution=grid.resolution,
        x=grid.x,
        y=grid.y,
        columns=grid.columns,
        rows=grid.rows,
        cells=occupied.T.tobytes(),
    )


def _static_shapes(world: World, engine: Engine, entities: Entities) -> Iterator[wire.SceneShape]:
    for wall in world.walls:
        yield describe_part(wall.part, WALL, wall.name)
    for slab in world.ground.slabs:
        place = BodyState((slab.place.x, slab.place.y, 0.0), quaternion(0.0, 0.0, slab.place.yaw))
        part = Part(Hull(slab.points.astype("<f8").tobytes())).placed(*place.frame)
        yield describe_part(part, TERRAIN, FLOOR)
    static = {name: model for name, model in entities.bodies.items() if model.static}
    for name, model in static.items():
        yield from _placed_shapes(name, model, engine.body_state(name))


def _placed_shapes(name: str, model: BodyModel, state: BodyState) -> Iterator[wire.SceneShape]:
    colour = colour_of(name, model.colour)
    for part in model.parts:
        yield describe_part(part.placed(state.position, state.orientation), colour, name)


def _height(parts: Iterable[Part]) -> float:
    return _rounded(max((highest_of(part, AT_ORIGIN) for part in parts), default=0.0))


def _planar(pose: Pose2) -> tuple[float, float, float]:
    return _rounded(pose.x), _rounded(pose.y), _rounded(pose.yaw)


def _rounded(value: float) -> float:
    return round(float(value), DIGITS) + 0.0  # no negative zero

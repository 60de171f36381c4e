"""Solid shapes of robots in their present posture, and the links that move against the base."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator
from functools import lru_cache

import numpy as np
from defusedxml import ElementTree

from sim_nodes.geometry import Quaternion, Vector, conjugate, multiply, rotated, vector
from sim_nodes.physics import BodyState, Engine, Part, PlacedRobot
from sim_nodes.robots.declaration import RobotDeclaration
from sim_nodes.robots.urdf_check import link_parts


@lru_cache(maxsize=16)
def moving_links(declaration: RobotDeclaration) -> tuple[str, ...]:
    """Return the links with solid shapes below the joints of an arm or a gripper; wheels are not among them."""
    if declaration.arm is None:
        return ()
    driven = {joint.name for joint in declaration.arm.joints} | set(declaration.arm.fingers)
    children: dict[str, list[str]] = defaultdict(list)
    found: list[str] = []
    for joint in ElementTree.fromstring(declaration.urdf).findall("joint"):
        child, parent = (str(end.get("link")) for tag in ("child", "parent") for end in joint.iterfind(tag))
        children[parent].append(child)
        if joint.get("name") in driven:
            found.append(child)
    for link in found:  # which grows
        found.extend(child for child in children[link] if child not in found)
    solid = link_parts(declaration)
    return tuple(link for link in dict.fromkeys(found) if solid.get(link))


def link_in_base(engine: Engine, robot: str, link: str, base: BodyState) -> tuple[Vector, Quaternion]:
    """Return the pose of a link in the frame of the robot's base [m].

    Args:
        engine: Engine with the present states.
        robot: Name of the robot.
        link: Name of the link.
        base: State of the base.
    """
    back = conjugate(base.orientation)
    position, orientation = engine.link_pose(robot, link)
    return rotated(back, vector(np.subtract(position, base.position))), multiply(back, orientation)


def parts_by_link(engine: Engine, robot: PlacedRobot, base: BodyState) -> Iterator[tuple[str, Part]]:
    """Yield the links and solid shapes of a robot in its present posture, in the frame of its base."""
    for link, parts in link_parts(robot.declaration).items():
        if parts:
            pose = link_in_base(engine, robot.name, link, base)
            yield from ((link, part.placed(*pose)) for part in parts)


def parts_of_robot(engine: Engine, robot: PlacedRobot, base: BodyState) -> Iterator[Part]:
    """Yield the solid shapes of a robot in its present posture, in the frame of its base."""
    return (part for _, part in parts_by_link(engine, robot, base))

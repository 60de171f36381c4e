"""What robots look like from outside: the shapes of their links."""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache

from defusedxml import ElementTree

from sim_nodes.models.urdf import read_origin, read_shape
from sim_nodes.physics import Part
from sim_nodes.robots.checking import SHAPES
from sim_nodes.robots.declaration import RobotDeclaration


@cache
def link_parts(declaration: RobotDeclaration) -> Mapping[str, tuple[Part, ...]]:
    """What of each link of a robot collides, in the link's frame, by the link's name."""
    root = ElementTree.fromstring(declaration.urdf)
    return {
        link.get("name", ""): tuple(
            Part(read_shape(collision, SHAPES), *read_origin(collision)) for collision in link.findall("collision")
        )
        for link in root.findall("link")
    }

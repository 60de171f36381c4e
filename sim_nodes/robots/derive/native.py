"""The base of robots from MJCF files, whose URDF begins with the world."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from defusedxml import ElementTree

from sim_nodes.models.urdf import WORLD_LINK
from sim_nodes.models.xml_reading import ORIGIN
from sim_nodes.physics import Urdf
from sim_nodes.robots.derive.model import read_model
from sim_nodes.robots.derive.rewriting import urdf_text


def without_world(urdf: Urdf, *, fixed: bool) -> Urdf:
    """Return the URDF of an MJCF file without the link of the world, if a single body is fixed to it.

    A robot that is not fixed stands where its world file puts it, so its place in the file does not matter.
    """
    model = read_model(urdf)
    below = [joint for joint in model.joints.values() if joint.parent == WORLD_LINK]
    if model.root != WORLD_LINK or model.solids[WORLD_LINK] or len(below) != 1 or below[0].is_movable:
        return urdf
    if fixed and model.frames[below[0].child] != ORIGIN:
        return urdf
    root: Any = ElementTree.fromstring(urdf.text)
    for element in list(root):
        if element.get("name") in (WORLD_LINK, below[0].name):
            root.remove(element)
    return replace(urdf, text=urdf_text(root))

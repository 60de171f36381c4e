"""Outline of a robot on the floor, and links that slide on it."""

from __future__ import annotations

import numpy as np

from sim_nodes.extents import lowest_of, outline
from sim_nodes.geometry import Array
from sim_nodes.models import xml_reading as xml
from sim_nodes.physics import BodyState
from sim_nodes.robots.derive.model import RobotModel
from sim_nodes.robots.derive.wheels import BaseFrame, Wheel
from sim_nodes.robots.footprint import Footprint, convex_footprint

SLIDING = 0.015  # [m] above the floor below which a link without a driven wheel slides on it
AT_ORIGIN = BodyState((0.0, 0.0, 0.0))
Links = tuple[str, ...]


def derive_footprint(model: RobotModel, base: BaseFrame) -> Footprint:
    """Return the outline of the solid shapes of a robot, as seen from above, in the frame of its base.

    Raises:
        RequestRefused: It has no extent.
    """
    parts = [part for solids in model.solids.values() for part in solids]
    points = np.vstack([outline(part, AT_ORIGIN) for part in parts])
    try:
        return convex_footprint(in_base(points, base))
    except ValueError as error:
        raise xml.invalid(str(error)) from error


def in_base(points: Array, base: BaseFrame) -> Array:
    """Return points of the root's frame in that of the base, shapes (n, 2) [m]."""
    return np.array([base.place((x, y, 0.0)) for x, y in points.tolist()])


def sliding_links(model: RobotModel, base: BaseFrame, wheels: tuple[Wheel, ...]) -> Links:
    """Return the links that touch the floor without being driven wheels, such as casters."""
    turning = {wheel.joint.child for wheel in wheels}
    return tuple(
        link
        for link, parts in model.solids.items()
        if model.carrier(link) not in turning
        and min((lowest_of(part, AT_ORIGIN) for part in parts), default=np.inf) - base.floor < SLIDING
    )


def is_supported(model: RobotModel, base: BaseFrame, wheels: tuple[Wheel, ...], sliding: Links) -> bool:
    """Whether the centre of mass is above the area between the wheels and the links that slide."""
    places = [np.array([base.place(wheel.centre)]) for wheel in wheels]
    low = [part for link in sliding for part in model.solids[link]]
    places += [
        in_base(np.array([part.position[:2]]), base)
        for part in low
        if lowest_of(part, AT_ORIGIN) - base.floor < SLIDING
    ]
    masses = np.array([model.masses[link] for link in model.frames])
    centres = np.array([model.centres[link] for link in model.frames])
    x, y, _ = (masses @ centres / masses.sum()).tolist()
    try:
        area = convex_footprint(np.vstack(places))
    except ValueError:
        return False
    return area.contains(base.place((x, y, 0.0)))

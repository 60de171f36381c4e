"""Terrain in MuJoCo: meshes, boxes and height fields of one body, whose contacts are counted like the floor's."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from sim_nodes.geometry import multiply, quaternion
from sim_nodes.terrain.ground import FLOOR_FRICTION, Ground, HeightField, Slab
from sim_nodes.views import TERRAIN

TERRAIN_BODY = "floor/terrain"  # no entity can have this name
LOOSE_PRIORITY = 2  # of geoms that slide or roll on anything, such as casters
GROUND_PRIORITY = 1  # of a floor with other friction than usual
TORSIONAL, ROLLING = 0.005, 0.0001  # MuJoCo's defaults for the two other friction coefficients
BASE = 0.1  # [m] of a height field below the floor
QUARTER_TURN = quaternion(0.0, 0.0, 1.5707963267948966)


def ground_priority(friction: float) -> int:
    """Return the priority of a geom of the floor with a friction.

    Without priority, a contact has the larger friction of the two, which would be that of the wheels.
    """
    return 0 if friction == FLOOR_FRICTION else GROUND_PRIORITY


def add_terrain(spec: Any, ground: Ground) -> None:
    """Add the terrain of a scene to its specification."""
    if ground.is_flat:
        return
    body = spec.worldbody.add_body(name=TERRAIN_BODY)
    for index, piece in enumerate(ground.pieces):
        name = f"{TERRAIN_BODY}/{index}"
        friction = ground.friction_of(piece)
        geom = (
            _add_slab(spec, body, name, piece) if isinstance(piece, Slab) else _add_field(spec, body, name, piece)
        )
        geom.name, geom.rgba = name, TERRAIN
        geom.friction, geom.priority = [friction, TORSIONAL, ROLLING], ground_priority(friction)


def _add_slab(spec: Any, body: Any, name: str, slab: Slab) -> Any:
    x, y, yaw = slab.place
    orientation = quaternion(0.0, 0.0, yaw)
    if slab.is_level:
        size = [slab.length / 2, slab.width / 2, slab.top / 2]
        return body.add_geom(type=mujoco.mjtGeom.mjGEOM_BOX, size=size, pos=[x, y, slab.top / 2], quat=orientation)
    spec.add_mesh(name=name, uservert=np.unique(slab.points, axis=0).ravel().tolist())
    return body.add_geom(type=mujoco.mjtGeom.mjGEOM_MESH, meshname=name, pos=[x, y, 0.0], quat=orientation)


def _add_field(spec: Any, body: Any, name: str, field: HeightField) -> Any:
    # MuJoCo splits cells along the other diagonal than Bullet, so the grid is turned by a quarter.
    grid = field.grid.T[::-1]
    spec.add_hfield(
        name=name,
        nrow=field.columns,
        ncol=field.rows,
        size=[field.width / 2, field.length / 2, field.top, BASE],
        userdata=(grid / field.top).ravel().tolist(),
    )
    x, y, yaw = field.place
    return body.add_geom(
        type=mujoco.mjtGeom.mjGEOM_HFIELD,
        hfieldname=name,
        pos=[x, y, 0.0],
        quat=multiply(quaternion(0.0, 0.0, yaw), QUARTER_TURN),
    )

"""Rays of ranging sensors, cast among the shapes that they can reach.

MuJoCo compares each ray with every body. Most bodies are out of range, or entirely above or below the plane of a
lidar. So a cast hides them, which changes no distance.
"""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from sim_nodes.geometry import Array, Vector
from sim_nodes.mujoco.groups import SEEN_BY_RAYS, VISUAL_GROUP

FLAT = 1e-9  # component of a direction out of the plane of the others
SLACK = 1e-6  # [m] beyond the bounds of shapes


class Rays:
    """Casts rays in a model.

    Args:
        model: The model. Its groups and geoms of bodies change during a cast only.
        data: Its data.
    """

    def __init__(self, model: Any, data: Any) -> None:
        self._model, self._data = model, data
        self._groups = np.zeros(6, dtype=np.uint8)
        self._groups[list(SEEN_BY_RAYS)] = 1
        # Values outside of a cast.
        self._group_of_geom = model.geom_group.copy()
        self._geoms_of_body, self._tree_of_body = model.body_geomnum.copy(), model.body_bvhadr.copy()
        self._is_seen = np.isin(self._group_of_geom, SEEN_BY_RAYS)
        self._root_of_geom = model.body_rootid[model.geom_bodyid]
        self._reach = np.where(model.geom_rbound > 0.0, model.geom_rbound + SLACK, np.inf)  # planes are endless

    def cast(self, body: int, own: int, directions: Array, limit: float, position: Vector) -> Array:
        """Return the distances to the nearest shapes up to a limit [m], infinite without any, shape (n,).

        Args:
            body: Number of the body that carries the sensor.
            own: Number of a body of the robot, which rays pass through.
            directions: Unit vectors in the frame of the body, shape (n, 3).
            limit: Maximum distance [m].
            position: Origin of the rays in the frame of the body [m].
        """
        model, data, count = self._model, self._data, len(directions)
        turn = data.xmat[body].reshape(3, 3)
        origin = data.xpos[body] + turn @ position
        hit, distance = np.zeros(count, dtype=np.int32), np.zeros(count)
        is_flat = bool(np.abs(directions[:, 2]).max() < FLAT)
        others = self._root_of_geom != model.body_rootid[own]
        self._hide(~(others & self._reachable(origin, limit, turn[:, 2] if is_flat else None)))
        try:
            mujoco.mj_multiRay(
                model,
                data,
                origin,
                (directions @ turn.T).ravel(),
                self._groups,
                1,
                own,
                hit,
                distance,
                None,
                count,
                limit,
            )
        finally:
            self._show_all()
        distance[(hit < 0) | (distance > limit)] = np.inf
        return distance

    def _reachable(self, origin: Array, limit: float, normal: Array | None) -> Any:
        """Return which geoms rays may hit; `normal` is that of the plane of the rays, if they are in one."""
        away = self._data.geom_xpos - origin
        reachable = self._is_seen & (np.sqrt(np.einsum("ij,ij->i", away, away)) - self._reach <= limit)
        if normal is not None:
            reachable &= np.abs(away @ normal) <= self._reach
        return reachable

    def _hide(self, geoms: Any) -> None:
        model = self._model
        model.geom_group[geoms] = VISUAL_GROUP
        empty = np.bincount(model.geom_bodyid[~geoms], minlength=model.nbody) == 0
        model.body_geomnum[empty], model.body_bvhadr[empty] = 0, -1

    def _show_all(self) -> None:
        model = self._model
        model.geom_group[:] = self._group_of_geom
        model.body_geomnum[:], model.body_bvhadr[:] = self._geoms_of_body, self._tree_of_body

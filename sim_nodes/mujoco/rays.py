"""Rays of ranging sensors, cast among the shapes that they can reach.

MuJoCo compares each ray with every body. Most bodies are out of range, or entirely above or below the plane of a
lidar. So a cast hides them, which changes no distance.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Indices
from sim_nodes.mujoco.groups import SEEN_BY_RAYS, VISUAL_GROUP
from sim_nodes.ray_bundles import RayBundle

Mask = NDArray[np.bool_]

SLACK = 1e-6  # [m] beyond the bounds of shapes


@dataclass(frozen=True)
class Cast:
    """A bundle of rays, with the numbers of the body that carries the sensor, and of one of the robot."""

    bundle: RayBundle
    body: int
    own: int


class Rays:
    """Casts rays in a model.

    Args:
        model: The model. Its groups and geoms of bodies change during casts only.
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
        self._with_geoms = np.flatnonzero(self._geoms_of_body)  # bodies, in the order of their geoms
        self._first_geoms = model.body_geomadr[self._with_geoms]
        self._reach = np.where(model.geom_rbound > 0.0, model.geom_rbound + SLACK, np.inf)  # planes are endless

    def cast(self, casts: Sequence[Cast]) -> list[Array]:
        """Return the distances of each cast to the nearest shapes [m], shape (n,); infinite without any."""
        data, limits = self._data, np.array([cast.bundle.limit for cast in casts])
        turns = [data.xmat[cast.body].reshape(3, 3) for cast in casts]
        origins = np.array(
            [data.xpos[c.body] + turn @ c.bundle.position for c, turn in zip(casts, turns, strict=True)]
        )
        groups, counts, trees = self._without_hidden(self._reachable(casts, origins, limits, turns))
        model = self._model
        try:
            found = []
            for number, (cast, turn) in enumerate(zip(casts, turns, strict=True)):
                model.geom_group[:] = groups[number]
                model.body_geomnum[:], model.body_bvhadr[:] = counts[number], trees[number]
                found.append(self._cast(cast, origins[number], cast.bundle.directions @ turn.T))
        finally:
            model.geom_group[:] = self._group_of_geom
            model.body_geomnum[:], model.body_bvhadr[:] = self._geoms_of_body, self._tree_of_body
        return found

    def _cast(self, cast: Cast, origin: Array, directions: Array) -> Array:
        count, limit = len(directions), cast.bundle.limit
        hit, distance = np.zeros(count, dtype=np.int32), np.zeros(count)
        mujoco.mj_multiRay(
            self._model,
            self._data,
            origin,
            directions.ravel(),
            self._groups,
            1,
            cast.own,
            hit,
            distance,
            None,
            count,
            limit,
        )
        distance[(hit < 0) | (distance > limit)] = np.inf
        return distance

    def _reachable(self, casts: Sequence[Cast], origins: Array, limits: Array, turns: Sequence[Array]) -> Mask:
        """Return which geoms the rays of casts may hit, shape (casts, geoms)."""
        roots = self._model.body_rootid[[cast.own for cast in casts]]
        away = self._data.geom_xpos - origins[:, None]
        distances = np.sqrt(np.einsum("cgi,cgi->cg", away, away))
        reachable: Mask = self._is_seen & (self._root_of_geom != roots[:, None])
        reachable &= distances - self._reach <= limits[:, None]
        is_flat = np.array([cast.bundle.is_flat for cast in casts])
        if is_flat.any():
            heights = np.abs(np.einsum("cgi,ci->cg", away, np.array([turn[:, 2] for turn in turns])))
            reachable &= (heights <= self._reach) | ~is_flat[:, None]
        return reachable

    def _without_hidden(self, reachable: Mask) -> tuple[Indices, Indices, Indices]:
        """Return groups of geoms, numbers of geoms of bodies, and trees of bodies, for each cast.

        Geoms that cannot be reached are in a hidden group; bodies with no other ones are empty.
        """
        empty = np.ones((len(reachable), len(self._geoms_of_body)), dtype=np.bool_)
        empty[:, self._with_geoms] = ~np.logical_or.reduceat(reachable, self._first_geoms, axis=1)
        return (
            np.where(reachable, self._group_of_geom, VISUAL_GROUP),
            np.where(empty, 0, self._geoms_of_body),
            np.where(empty, -1, self._tree_of_body),
        )

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
        self._seen = np.flatnonzero(np.isin(self._group_of_geom, SEEN_BY_RAYS))  # geoms
        bodies = model.geom_bodyid[self._seen]
        self._with_seen, self._first_seen = np.unique(bodies, return_index=True)
        self._without_seen = np.setdiff1d(np.arange(model.nbody), self._with_seen, assume_unique=True)
        self._root_of_seen = model.body_rootid[bodies]
        radius = model.geom_rbound[self._seen]
        self._reach = np.where(radius > 0.0, radius + SLACK, np.inf)  # planes are endless

    def cast(self, casts: Sequence[Cast]) -> list[Array]:
        """Return the distances of each cast to the nearest shapes [m], shape (n,); infinite without any."""
        data, limits = self._data, np.array([cast.bundle.limit for cast in casts])
        turns = [data.xmat[cast.body].reshape(3, 3) for cast in casts]
        origins = np.array(
            [data.xpos[c.body] + turn @ c.bundle.position for c, turn in zip(casts, turns, strict=True)]
        )
        hidden = self._without_hidden(self._reachable(casts, origins, limits, turns))
        seen, bodies, others = self._seen, self._with_seen, self._without_seen
        group, geoms, tree = self._model.geom_group, self._model.body_geomnum, self._model.body_bvhadr
        found = []
        try:
            geoms[others], tree[others] = 0, -1
            for cast, turn, origin, *without in zip(casts, turns, origins, *hidden, strict=True):
                group[seen], geoms[bodies], tree[bodies] = without
                found.append(self._cast(cast, origin, cast.bundle.directions @ turn.T))
        finally:
            group[:], geoms[:], tree[:] = self._group_of_geom, self._geoms_of_body, self._tree_of_body
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
        """Return which of the seen geoms the rays of casts may hit, shape (casts, seen geoms)."""
        roots = self._model.body_rootid[[cast.own for cast in casts]]
        away = self._data.geom_xpos[self._seen] - origins[:, None]
        distances = np.sqrt(np.einsum("cgi,cgi->cg", away, away))
        reachable: Mask = self._root_of_seen != roots[:, None]
        reachable &= distances - self._reach <= limits[:, None]
        is_flat = np.array([cast.bundle.is_flat for cast in casts])
        if is_flat.any():
            heights = np.abs(np.einsum("cgi,ci->cg", away, np.array([turn[:, 2] for turn in turns])))
            reachable &= (heights <= self._reach) | ~is_flat[:, None]
        return reachable

    def _without_hidden(self, reachable: Mask) -> tuple[Indices, Indices, Indices]:
        """Return groups of seen geoms, and numbers of geoms and trees of their bodies, for each cast.

        Geoms that cannot be reached are in a hidden group; bodies with no other ones are empty.
        """
        some, bodies = np.logical_or.reduceat(reachable, self._first_seen, axis=1), self._with_seen
        return (
            np.where(reachable, self._group_of_geom[self._seen], VISUAL_GROUP),
            np.where(some, self._geoms_of_body[bodies], 0),
            np.where(some, self._tree_of_body[bodies], -1),
        )

"""Rays of several robots, cast in one call by engines that gain from it."""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache, cached_property
from typing import Protocol, TypeGuard, runtime_checkable

import numpy as np

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, Vector
from sim_nodes.physics import Engine

FLAT = 1e-9  # component of a direction out of the plane of the others


@dataclass(frozen=True, eq=False)
class RayBundle:
    """Arguments of `Engine.cast_rays`."""

    robot: str
    link: str
    directions: Array
    limit: float
    position: Vector = (0.0, 0.0, 0.0)

    @cached_property
    def is_flat(self) -> bool:
        """Whether all rays are in the plane z = 0 of the link."""
        return bool(np.abs(self.directions[:, 2]).max() < FLAT)


@runtime_checkable
class CastsTogether(Protocol):
    """An engine that casts the rays of several robots in one call."""

    def cast_together(self, bundles: Sequence[RayBundle]) -> list[Array]:
        """Return for each bundle what `Engine.cast_rays` returns for it."""


def cast(engine: Engine, bundles: Sequence[RayBundle]) -> list[Array]:
    """Return the distances along the rays of bundles; see `Engine.cast_rays`."""
    if _casts_together(engine):
        return engine.cast_together(bundles)
    return [
        engine.cast_rays(each.robot, each.link, each.directions, each.limit, each.position) for each in bundles
    ]


def _casts_together(engine: Engine) -> TypeGuard[CastsTogether]:
    return _is_subclass(type(engine))


@cache
def _is_subclass(kind: type) -> bool:
    """Whether engines of a class cast together, which takes long to find out."""
    return issubclass(kind, CastsTogether)

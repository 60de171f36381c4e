"""Rules for engines that cast the rays of several robots in one call."""

from __future__ import annotations

import numpy as np

from sim_nodes.check.bench import CUBE, LIDAR, ORIGIN, OTHER, ROBOT, Make, at, body, built, expect, run
from sim_nodes.check.sensing import DIRECTIONS, LIMIT, ROOM
from sim_nodes.geometry import Pose2
from sim_nodes.ray_bundles import CastsTogether, RayBundle

TILTED = DIRECTIONS * 0.96 + np.array([0.0, 0.0, 0.28]) * np.ones_like(DIRECTIONS)
BUNDLES = (
    RayBundle(ROBOT, LIDAR.link, DIRECTIONS, LIMIT),
    RayBundle(OTHER, LIDAR.link, DIRECTIONS[::3], 1.0),
    RayBundle(OTHER, LIDAR.link, TILTED, LIMIT, (0.0, 0.0, 0.1)),
    RayBundle(ROBOT, LIDAR.link, DIRECTIONS[:1], LIMIT),
)


def rays_cast_together_are_those_cast_alone(make: Make) -> None:
    """Rays of several robots in one call end exactly where those of each robot alone end."""
    engine = built(make, ORIGIN, Pose2(1.2, 0.3, 1.0), walls=ROOM)
    engine.add_body("body", body(CUBE), at(-1.0, 0.2, 0.2))
    run(engine, 0.5)
    assert isinstance(engine, CastsTogether)
    together = engine.cast_together(BUNDLES)
    expect(len(together) == len(BUNDLES), f"{len(BUNDLES)} bundles gave {len(together)} arrays")
    for number, (bundle, found) in enumerate(zip(BUNDLES, together, strict=True)):
        alone = engine.cast_rays(bundle.robot, bundle.link, bundle.directions, bundle.limit, bundle.position)
        wrong = int((found != alone).sum()) if found.shape == alone.shape else len(alone)
        expect(not wrong, f"{wrong} of {len(alone)} rays of bundle {number} end elsewhere than alone")

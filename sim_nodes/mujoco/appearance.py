"""Appearance of MuJoCo scenes: floor, sky, light and visible shapes. It does not affect physics."""

from __future__ import annotations

import math
from typing import Any

import mujoco

from sim_nodes.colours import FLOOR_TILES, LIGHT_DIRECTION, SKY, TILE

# Groups of geoms. URDF collision shapes are visible only if a link has no visuals.
SOLID_GROUP, VISUAL_GROUP, HIDDEN_GROUP = 0, 1, 3
SEEN_BY_RAYS = (SOLID_GROUP, HIDDEN_GROUP)
DRAWN_GROUPS = (SOLID_GROUP, VISUAL_GROUP)
FLOOR_MATERIAL = "floor"
SUN_DISTANCE = 20.0  # [m]; shadows are sharp about the point where its rays meet the floor
SHADOW_REACH = 0.6  # share of the diagonal of the floor
SHADOW_SIZE = 1024  # [pixels]; MuJoCo's 4096 more than doubles the time of software rendering


def add_appearance(spec: Any, extent: tuple[float, float, float, float]) -> None:
    """Add floor, sky and light to a scene; `extent` is that of the floor [m]."""
    left, bottom, right, top = extent
    centre = ((left + right) / 2, (bottom + top) / 2, 0.0)
    quality, light = spec.visual.quality, spec.visual.headlight
    quality.shadowsize, quality.offsamples = SHADOW_SIZE, 0
    # Limits shadows, beyond which floors have artefacts; MuJoCo's own estimate ignores floors.
    spec.stat.extent, spec.stat.center = SHADOW_REACH * math.hypot(right - left, top - bottom), centre
    light.ambient, light.diffuse, light.specular = [0.4] * 3, [0.2] * 3, [0.0] * 3
    spec.worldbody.add_light(
        type=mujoco.mjtLightType.mjLIGHT_DIRECTIONAL,
        dir=LIGHT_DIRECTION,
        pos=[at - SUN_DISTANCE * along for at, along in zip(centre, LIGHT_DIRECTION, strict=True)],
        diffuse=[0.5] * 3,
        specular=[0.0] * 3,
    )
    spec.add_texture(
        name="sky",
        type=mujoco.mjtTexture.mjTEXTURE_SKYBOX,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_FLAT,
        rgb1=SKY[:3],
        rgb2=SKY[:3],
        width=8,
        height=8,
    )
    first, second = FLOOR_TILES
    spec.add_texture(
        name=FLOOR_MATERIAL,
        type=mujoco.mjtTexture.mjTEXTURE_2D,
        builtin=mujoco.mjtBuiltin.mjBUILTIN_CHECKER,
        rgb1=first[:3],
        rgb2=second[:3],
        width=256,
        height=256,
    )
    textures = [""] * mujoco.mjtTextureRole.mjNTEXROLE.value
    textures[mujoco.mjtTextureRole.mjTEXROLE_RGB] = FLOOR_MATERIAL
    repeat = 1.0 / TILE
    spec.add_material(name=FLOOR_MATERIAL, textures=textures, texuniform=True, texrepeat=[repeat, repeat])


def hide_collision_shapes(robot: Any) -> None:
    """Hide the collision shapes of links that have visuals."""
    for body in robot.bodies:
        geoms = list(body.geoms)
        if any(not geom.contype for geom in geoms):
            for geom in geoms:
                if geom.contype:
                    geom.group = HIDDEN_GROUP

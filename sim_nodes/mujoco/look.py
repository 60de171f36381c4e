"""What MuJoCo's scenes look like: floor, sky, light, and which shapes are drawn. Nothing of it acts on physics."""

from __future__ import annotations

import math
from typing import Any

import mujoco

from sim_nodes.colours import FLOOR_TILES, LIGHT_DIRECTION, SKY, TILE

# Groups of shapes. URDF's collision shapes are drawn only where a link has no visual ones.
SOLID_GROUP, VISUAL_GROUP, HIDDEN_GROUP = 0, 1, 3
SEEN_BY_RAYS = (SOLID_GROUP, HIDDEN_GROUP)
DRAWN_GROUPS = (SOLID_GROUP, VISUAL_GROUP)
FLOOR_MATERIAL = "floor"
SUN_DISTANCE = 20.0  # [m]; shadows are sharp about where its rays meet the floor
SHADOW_REACH = 0.6  # of the diagonal of the floor
SHADOW_SIZE = 1024  # [pixels]; with MuJoCo's 4096 software takes more than twice as long for a picture


def add_look(spec: Any, extent: tuple[float, float, float, float]) -> None:
    """Give a scene its floor, sky and light; the extent is the floor's [m]."""
    left, bottom, right, top = extent
    centre = ((left + right) / 2, (bottom + top) / 2, 0.0)
    quality, light = spec.visual.quality, spec.visual.headlight
    quality.shadowsize, quality.offsamples = SHADOW_SIZE, 0
    # As far as shadows reach, beyond which floors have spots; MuJoCo's own estimate leaves floors out.
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


def hide_solids(robot: Any) -> None:
    """Leave out of pictures the collision shapes of links that have others to look at."""
    for body in robot.bodies:
        geoms = list(body.geoms)
        if any(not geom.contype for geom in geoms):
            for geom in geoms:
                if geom.contype:
                    geom.group = HIDDEN_GROUP

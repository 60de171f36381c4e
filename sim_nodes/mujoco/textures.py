"""Textures of compiled models of MuJoCo, for other engines: as pictures on meshes, or as mean colours."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from sim_nodes.models.meshes import Mesh
from sim_nodes.models.pictures import LARGEST, to_png

RGB = int(mujoco.mjtTextureRole.mjTEXROLE_RGB)
FLAT = int(mujoco.mjtTexture.mjTEXTURE_2D)
NONE = -1
GEOMS = mujoco.mjtGeom
PICTURED = {int(kind) for kind in (GEOMS.mjGEOM_BOX, GEOMS.mjGEOM_CYLINDER, GEOMS.mjGEOM_SPHERE)}


def texture_of(model: Any, geom: int) -> int | None:
    """Return the number of the texture that colours a geom; None without one."""
    material = int(model.geom_matid[geom])
    texture = NONE if material == NONE else int(model.mat_texid[material, RGB])
    return None if texture == NONE else texture


def shows_picture(model: Any, geom: int) -> bool:
    """Whether a geom is a mesh with texture coordinates and a flat texture."""
    texture = texture_of(model, geom)
    if texture is None or model.tex_type[texture] != FLAT or model.geom_type[geom] != mujoco.mjtGeom.mjGEOM_MESH:
        return False
    return bool(model.mesh_texcoordadr[model.geom_dataid[geom]] != NONE)


def shows_on_shape(model: Any, geom: int) -> bool:
    """Whether a geom is a box, cylinder or sphere with a flat texture."""
    texture = texture_of(model, geom)
    return texture is not None and model.tex_type[texture] == FLAT and int(model.geom_type[geom]) in PICTURED


def picture(model: Any, texture: int) -> bytes:
    """Return a texture as a picture in PNG."""
    found = Image.fromarray(_pixels(model, texture))
    found.thumbnail((LARGEST, LARGEST))
    return to_png(found)


def mean_tint(model: Any, texture: int) -> NDArray[np.float64]:
    """Return the mean colour of a texture: red, green and blue from 0 to 1, shape (3,)."""
    mean: NDArray[np.float64] = _pixels(model, texture).reshape(-1, 3).mean(axis=0) / 255.0
    return mean


def _pixels(model: Any, texture: int) -> NDArray[np.uint8]:
    """Return the pixels of a texture, shape (height, width, 3)."""
    height, width, channels = (
        int(size[texture]) for size in (model.tex_height, model.tex_width, model.tex_nchannel)
    )
    start = int(model.tex_adr[texture])
    data = model.tex_data[start : start + height * width * channels].reshape(height, width, channels)
    return np.repeat(data, 3, axis=2) if channels == 1 else np.ascontiguousarray(data[:, :, :3])


def textured_mesh(model: Any, mesh: int) -> Mesh:
    """Return a mesh with texture coordinates; corners with several of them are repeated."""
    first, corners = int(model.mesh_faceadr[mesh]), int(model.mesh_facenum[mesh])
    vertices = model.mesh_vert[int(model.mesh_vertadr[mesh]) :]
    coordinates = model.mesh_texcoord[int(model.mesh_texcoordadr[mesh]) :]
    faces = [each[first : first + corners].ravel() for each in (model.mesh_face, model.mesh_facetexcoord)]
    pairs, numbers = np.unique(np.stack(faces, axis=1), axis=0, return_inverse=True)
    right, down = coordinates[pairs[:, 1]].astype(np.float64).T
    return Mesh(
        vertices[pairs[:, 0]].astype(np.float64),
        numbers.reshape(-1, 3),
        coordinates=np.stack([right, 1.0 - down], axis=1),  # MuJoCo has them from the upper left corner
    )

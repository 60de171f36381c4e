"""Off-screen rendering by MuJoCo: with EGL, or OSMesa where EGL does not work.

Rendering libraries are loaded for the first image. States are copied before rendering, because MuJoCo writes
positions and lights into them.
"""

from __future__ import annotations

import ctypes
import math
import os
from collections.abc import Sequence
from functools import cache
from typing import Any

import mujoco
import numpy as np

from sim_nodes.mujoco.groups import DRAWN_GROUPS
from sim_nodes.views import FAR, NEAR, DepthImage, Depths, NoRendering, Picture, View

AS_NUMBERS = [int(mujoco.mjtRndFlag.mjRND_SEGMENT), int(mujoco.mjtRndFlag.mjRND_IDCOLOR)]
DIGITS = np.array([1, 1 << 8, 1 << 16], dtype=np.int32)  # of the number of a shape, by red, green and blue
MAX_SHAPES = 10_000
CHOICE = "MUJOCO_GL"  # environment variable with the rendering backend of MuJoCo
HELP = (
    "MuJoCo renders with EGL or OSMesa, and neither works here; on Debian and Ubuntu: apt-get install "
    "libegl1 libegl-mesa0 libgl1-mesa-dri, or libosmesa6"
)


class Renderer:
    """Renders models in their states.

    Raises:
        NoRendering: Neither backend works.
    """

    def __init__(self) -> None:
        self._gl = _gl_context()
        self._model: Any = None
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = 0
        self._option.geomgroup[list(DRAWN_GROUPS)] = 1
        self._free_camera = mujoco.MjvCamera()

    def draw(self, model: Any, data: Any, view: View) -> Picture:
        """Render a view."""
        rectangle = self._prepare(model, data, view)
        mujoco.mjr_render(rectangle, self._scene, self._context)
        pixels = np.empty((rectangle.height, rectangle.width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(pixels, None, rectangle, self._context)
        return pixels[::-1].copy()  # OpenGL's first row is the bottom one

    def measure(self, model: Any, data: Any, view: View, owners: Sequence[str]) -> DepthImage:
        """Measure the distances of a view; `owners` are the entities of geoms."""
        rectangle = self._prepare(model, data, view)
        scene = self._scene
        scene.flags[AS_NUMBERS] = 1
        mujoco.mjr_render(rectangle, scene, self._context)
        scene.flags[AS_NUMBERS] = 0
        shape = (rectangle.height, rectangle.width)
        pixels, buffer = np.empty((*shape, 3), dtype=np.uint8), np.empty(shape, dtype=np.float32)
        mujoco.mjr_readPixels(pixels, buffer, rectangle, self._context)
        numbers = pixels[::-1].astype(np.int32) @ DIGITS

        def owner(number: int) -> str | None:
            if not number:
                return None
            shape = scene.geoms[number - 1]
            return owners[shape.objid] if shape.objtype == mujoco.mjtObj.mjOBJ_GEOM else None

        return DepthImage.of(_distances(buffer[::-1]), numbers, owner)

    def _prepare(self, model: Any, data: Any, view: View) -> Any:
        """Update the scene for a view; return the rectangle of its pixels."""
        self._gl.make_current()  # for this thread
        if model is not self._model:
            self._load(model)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        width, height = view.lens.width, view.lens.height
        if (self._context.offWidth, self._context.offHeight) != (width, height):
            mujoco.mjr_resizeOffscreen(width, height, self._context)
        copy = self._copy
        mujoco.mj_copyData(copy, model, data)
        mujoco.mj_kinematics(model, copy)  # after a step, positions are still those before it
        mujoco.mj_comPos(model, copy)
        mujoco.mj_camlight(model, copy)
        mujoco.mjv_updateScene(
            model, copy, self._option, None, self._free_camera, mujoco.mjtCatBit.mjCAT_ALL, self._scene
        )
        for camera in self._scene.camera:  # one for each eye
            _aim(camera, view)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        return mujoco.MjrRect(0, 0, width, height)

    def _load(self, model: Any) -> None:
        """Load the visual data of a model."""
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        self._context.readDepthMap = mujoco.mjtDepthMap.mjDEPTH_ZEROFAR  # precise also far away
        self._scene = mujoco.MjvScene(model, maxgeom=MAX_SHAPES)
        self._copy = mujoco.MjData(model)
        self._model = model


def _distances(buffer: Depths) -> Depths:
    """Return the distances of a depth buffer, which has 1 at the near plane and 0 at the far plane [m]."""
    distances: Depths = (NEAR * FAR / (NEAR + buffer.astype(np.float64) * (FAR - NEAR))).astype(np.float32)
    distances[buffer <= 0.0] = np.inf
    return distances


def _aim(camera: Any, view: View) -> None:
    ahead, up = view.axes
    camera.pos[:] = view.position
    camera.forward[:] = ahead
    camera.up[:] = up
    half = NEAR * math.tan(view.lens.fov / 2)
    camera.frustum_near, camera.frustum_far = NEAR, FAR
    camera.frustum_bottom, camera.frustum_top = -half, half
    camera.frustum_center, camera.frustum_width = 0.0, half * view.lens.aspect


@cache
def _gl_context() -> Any:
    """Return the off-screen OpenGL context of the process.

    All renderers share it: MuJoCo frees the OpenGL objects of a deleted renderer in the current context, and would
    free those with the same numbers in another renderer's context.
    """
    try:
        if _backend() == "egl":
            from mujoco.egl import GLContext  # noqa: PLC0415 - chooses how PyOpenGL works, for the whole process
        else:
            from mujoco.osmesa import GLContext  # noqa: PLC0415
        return GLContext(1, 1)
    except Exception as error:  # each library has its own exceptions
        raise NoRendering(f"{HELP} ({type(error).__name__}: {error})") from error


def _backend() -> str:
    chosen = os.environ.get(CHOICE, "").lower()
    return chosen if chosen in ("egl", "osmesa") else "egl" if _has_egl_devices() else "osmesa"


def _has_egl_devices() -> bool:
    """Whether EGL has a device. PyOpenGL cannot be used: it supports one backend per process."""
    try:
        library = ctypes.CDLL("libEGL.so.1")
    except OSError:
        return False
    library.eglGetProcAddress.restype = ctypes.c_void_p
    address = library.eglGetProcAddress(b"eglQueryDevicesEXT")
    if not address:
        return False
    query = ctypes.CFUNCTYPE(ctypes.c_uint, ctypes.c_int, ctypes.c_void_p, ctypes.POINTER(ctypes.c_int))(address)
    count = ctypes.c_int(0)
    return bool(query(0, None, ctypes.byref(count))) and count.value > 0

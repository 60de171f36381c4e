"""Pictures by MuJoCo's renderer, drawn without a display: by EGL, or by OSMesa where that does not work.

Nothing of it is loaded before the first picture. States are copied before they are drawn: to find places and
lights, MuJoCo writes into them.
"""

from __future__ import annotations

import ctypes
import math
import os
from functools import cache
from typing import Any

import mujoco
import numpy as np

from sim_nodes.mujoco.look import DRAWN_GROUPS
from sim_nodes.views import FAR, NEAR, NoRendering, Picture, View

MAX_SHAPES = 10_000
CHOICE = "MUJOCO_GL"  # environment variable by which users of MuJoCo choose how it draws
HELP = (
    "MuJoCo draws pictures by EGL or OSMesa, and neither works here; on Debian and Ubuntu: apt-get install "
    "libegl1 libegl-mesa0 libgl1-mesa-dri, or libosmesa6"
)


class Renderer:
    """Draws models and their states.

    Raises:
        NoRendering: There is no way to draw.
    """

    def __init__(self) -> None:
        self._gl = _gl_context()
        self._model: Any = None
        self._option = mujoco.MjvOption()
        self._option.geomgroup[:] = 0
        self._option.geomgroup[list(DRAWN_GROUPS)] = 1
        self._free_camera = mujoco.MjvCamera()

    def draw(self, model: Any, data: Any, view: View) -> Picture:
        """What is seen from a view."""
        self._gl.make_current()  # in this thread
        if model is not self._model:
            self._take(model)
        mujoco.mjr_setBuffer(mujoco.mjtFramebuffer.mjFB_OFFSCREEN, self._context)
        width, height = view.lens.width, view.lens.height
        if (self._context.offWidth, self._context.offHeight) != (width, height):
            mujoco.mjr_resizeOffscreen(width, height, self._context)
        copy = self._copy
        mujoco.mj_copyData(copy, model, data)
        mujoco.mj_kinematics(model, copy)  # after a step, places are still those of before it
        mujoco.mj_comPos(model, copy)
        mujoco.mj_camlight(model, copy)
        mujoco.mjv_updateScene(
            model, copy, self._option, None, self._free_camera, mujoco.mjtCatBit.mjCAT_ALL, self._scene
        )
        for camera in self._scene.camera:  # MuJoCo has one for each eye
            _aim(camera, view)
        self._scene.flags[mujoco.mjtRndFlag.mjRND_REFLECTION] = 0
        rectangle = mujoco.MjrRect(0, 0, width, height)
        mujoco.mjr_render(rectangle, self._scene, self._context)
        pixels = np.empty((height, width, 3), dtype=np.uint8)
        mujoco.mjr_readPixels(pixels, None, rectangle, self._context)
        return pixels[::-1].copy()  # OpenGL's first row is the lowest

    def _take(self, model: Any) -> None:
        """Load what is drawn of a model."""
        self._context = mujoco.MjrContext(model, mujoco.mjtFontScale.mjFONTSCALE_100)
        self._scene = mujoco.MjvScene(model, maxgeom=MAX_SHAPES)
        self._copy = mujoco.MjData(model)
        self._model = model


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
    """The process's context of OpenGL, without a window.

    There is one for all renderers: MuJoCo takes what a renderer that is gone had in OpenGL out of the context that
    is current at that moment, and from another's would take what has the same numbers there.
    """
    try:
        if _wanted() == "egl":
            from mujoco.egl import GLContext  # noqa: PLC0415 - chooses how PyOpenGL works, for the whole process
        else:
            from mujoco.osmesa import GLContext  # noqa: PLC0415
        return GLContext(1, 1)
    except Exception as error:  # of several libraries, each with exceptions of its own
        raise NoRendering(f"{HELP} ({type(error).__name__}: {error})") from error


def _wanted() -> str:
    chosen = os.environ.get(CHOICE, "").lower()
    return chosen if chosen in ("egl", "osmesa") else "egl" if _has_egl_devices() else "osmesa"


def _has_egl_devices() -> bool:
    """Whether EGL has anything to draw with. PyOpenGL cannot be asked: it is for one way to draw in a process."""
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

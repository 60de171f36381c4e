"""The MuJoCo engine; the only folder that imports mujoco.

MuJoCo loads rendering libraries on import, also where MUJOCO_GL names missing ones. Simulation does not need them:
they are loaded for the first image (`camera.py`).
"""

import logging
import os

_chosen = os.environ.get("MUJOCO_GL")
os.environ["MUJOCO_GL"] = "disabled"
try:
    import mujoco  # before the modules of this folder import it
finally:
    if _chosen is None:
        del os.environ["MUJOCO_GL"]
    else:
        os.environ["MUJOCO_GL"] = _chosen

# Otherwise MuJoCo writes warnings to a file in the working directory.
mujoco.set_mju_user_warning(logging.getLogger(__name__).warning)

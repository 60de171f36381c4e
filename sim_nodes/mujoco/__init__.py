"""The MuJoCo engine; the only folder that imports mujoco.

If MUJOCO_GL is set, MuJoCo loads its rendering libraries on import, and fails where they are missing. Simulation
does not need them: they are loaded for the first image (`camera.py`).
"""

import logging
import os

_chosen = os.environ.pop("MUJOCO_GL", None)
try:
    import mujoco  # so that the variable is not there when the modules of this folder import it
finally:
    if _chosen is not None:
        os.environ["MUJOCO_GL"] = _chosen

# Otherwise MuJoCo writes warnings to a file in the working directory.
mujoco.set_mju_user_warning(logging.getLogger(__name__).warning)

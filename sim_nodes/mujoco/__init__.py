"""The MuJoCo engine; the only folder that imports mujoco.

If MUJOCO_GL is set, MuJoCo loads its rendering libraries on import, and fails where they are missing. Simulation
does not need them: they are loaded for the first image (`camera.py`).
"""

import os

_chosen = os.environ.pop("MUJOCO_GL", None)
try:
    import mujoco  # noqa: F401 - so that it is not there when the modules of this folder import it
finally:
    if _chosen is not None:
        os.environ["MUJOCO_GL"] = _chosen

"""The MuJoCo engine: the only folder that imports mujoco.

MuJoCo loads what it draws with when it is imported, if MUJOCO_GL names it, and cannot be imported where that is
missing. A simulation does without: what draws is loaded for the first picture (`camera.py`).
"""

import os

_chosen = os.environ.pop("MUJOCO_GL", None)
try:
    import mujoco  # noqa: F401 - so that it is not there when the modules of this folder import it
finally:
    if _chosen is not None:
        os.environ["MUJOCO_GL"] = _chosen

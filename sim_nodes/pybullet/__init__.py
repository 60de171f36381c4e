"""The PyBullet engine; the only folder that imports pybullet.

On import, pybullet prints its build time, which is captured here.
"""

from __future__ import annotations

from sim_nodes.pybullet.output import captured_output

with captured_output():
    import pybullet  # noqa: F401 - so that it is there when the modules of this folder import it

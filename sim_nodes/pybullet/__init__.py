"""The PyBullet engine; the only folder that imports pybullet."""

"""The MuJoCo engine: the only folder that imports mujoco."""

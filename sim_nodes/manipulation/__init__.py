"""Arm control: kinematics, collision-checked paths, trajectories and gripping."""

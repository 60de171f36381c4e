"""What a simulated arm does by itself: kinematics, paths that are checked first, trajectories, gripping."""

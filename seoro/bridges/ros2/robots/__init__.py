"""Bridge of ROS 2 robots: a node of seoro that serves requests by the topics, services and actions of robots.

`profile.py` has the names of a family of robots, `running.py` connects both sides. A robot (`robot.py`) has a
driving base (`base.py`), or an arm (`arm.py`), or both. A base has `velocity.py`, `navigation.py` and
`localisation.py`. `link.py` has the topics and services of a robot, `frames.py` its frames, `pursuit.py` the goals
of its actions. `guard.py` is a process that stops the robots when the bridge (`guarded.py`) cannot. It also
cancels orphaned goals (`orphaned_goals.py`).
"""

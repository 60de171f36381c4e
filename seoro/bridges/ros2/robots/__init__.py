"""ROS 2 robots served as a node: what scenarios ask of robots, by the topics, services and actions of ROS 2.

`profile.py` says what a family of robots calls them, `running.py` connects both sides. A robot (`robot.py`) has a
base that drives (`base.py`, with `velocity.py`, `navigation.py` and `localisation.py`), or an arm (`arm.py`), or
both. `link.py` is what it is spoken to by, `frames.py` where its frames are, `pursuit.py` goals of its actions.
`guard.py` is a process that stops the robots when the bridge (`guarded.py`) cannot, and cancels goals that were
left behind (`leftovers.py`).
"""

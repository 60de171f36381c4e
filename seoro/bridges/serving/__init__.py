"""Robots as a node: what all bridges to robots share, whatever the robots speak.

`node.py` serves the verbs, `hold.py` knows who holds the robots and stops them when nobody does, `work.py` keeps
their goals and watches, `happenings.py` what has happened. `robot.py` says what a robot has to offer.
"""

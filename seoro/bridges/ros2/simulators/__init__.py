"""Simulators with ROS `simulation_interfaces` as simulator nodes: Gazebo, Isaac Sim, O3DE, Webots.

`interfaces.py` calls the services, `world.py` has the time and the poses of the simulation, and `node.py` serves
the verbs of simulator nodes. Robots in such a simulator are accessed by their topics, like real robots.
"""

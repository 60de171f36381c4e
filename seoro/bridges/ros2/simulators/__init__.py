"""Simulators of the ROS world as simulator nodes, by ROS `simulation_interfaces`: Gazebo, Isaac Sim, O3DE, Webots.

`interfaces.py` calls the services, `world.py` is the simulation as its client sees it (time, states of entities),
`node.py` serves the verbs of simulator nodes with it. Robots in such a simulator are reached as robots
are: by the topics that they have.
"""

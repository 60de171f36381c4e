"""A simulator node as a ROS 2 system: its robots as topics and actions, the simulator as `simulation_interfaces`.

`running.py` puts it together. `node.py` asks the simulator node and follows it; `messages.py` says what its robots
sense as messages of ROS 2, `links.py` where the links of their URDFs are. `robot.py` exposes a robot,
`navigation.py` and `arms.py` its actions; `simulation.py` exposes the simulator.
"""

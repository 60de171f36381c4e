"""A simulator node as a ROS 2 system: its robots as topics and actions, the simulator as `simulation_interfaces`.

`running.py` connects both sides. `node.py` is the client of the simulator node. `messages.py` converts samples to
ROS 2 messages, and `links.py` computes the links of URDFs. `robot.py` exposes a robot, `navigation.py` and
`arms.py` its actions. `simulation.py` exposes the simulator, with the conversions in `entities.py`.
"""

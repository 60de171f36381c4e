"""Clients of actions, parameters and life cycles of ROS 2."""

"""Runs that other nodes start and stop by services of ROS 2."""

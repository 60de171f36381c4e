"""Adoption of robots: profiles of the robots of a running ROS 2 system.

`finding` finds robots in the graph, `survey` reads messages and parameters of each, and `drafting` derives a
profile with notes on its sources.
"""

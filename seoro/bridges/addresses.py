"""Default endpoints, and the largest domain of ROS 2."""

from __future__ import annotations

from typing import Final

EXECUTOR: Final = "tcp/127.0.0.1:7470"
ROS_ROUTER: Final = "tcp/127.0.0.1:7447"  # of rmw_zenohd and the bridge for DDS on the robot
BRIDGE: Final = "tcp/127.0.0.1:7460"  # of bridges to robots, for runs
LARGEST_DOMAIN: Final = 232  # limited by the ports of DDS

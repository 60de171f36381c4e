"""Where systems of ROS 2 are: what holds unless somebody says otherwise, and what there can be."""

from __future__ import annotations

ROUTER = "tcp/127.0.0.1:7447"  # where rmw_zenohd and the bridge for DDS listen on the robot itself
LARGEST_DOMAIN = 232  # the ports of DDS have room for no more, and ROS 2 allows no more anywhere

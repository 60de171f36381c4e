"""ROS 2 over Zenoh, without a ROS installation: its interfaces, its wire, its graph and its robots."""

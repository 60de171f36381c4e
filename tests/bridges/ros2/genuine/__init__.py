"""seoro with genuine ROS 2 nodes: rclpy over rmw_zenoh_cpp, in separate processes."""

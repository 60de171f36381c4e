"""seoro against nodes of ROS 2 itself: rclpy over rmw_zenoh_cpp, in processes of their own."""

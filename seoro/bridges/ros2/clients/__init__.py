"""What is built of topics and services in ROS 2: actions, parameters, life cycles, transforms."""

"""Recording and playing bags, as rosbag2 has them."""

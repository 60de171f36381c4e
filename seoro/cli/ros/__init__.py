"""What `seoro ros` does, a module for each kind of thing that there is in a ROS 2 system."""

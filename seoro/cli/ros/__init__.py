"""Commands of `seoro ros`: one module per kind of entity of a ROS 2 system."""

"""Commands of `seoro ros`: the graph, topics, requests to nodes, and bags of a ROS 2 system."""

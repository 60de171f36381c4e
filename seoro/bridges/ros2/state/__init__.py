"""The state of a run on topics of ROS 2, for RViz, Foxglove and dashboards."""

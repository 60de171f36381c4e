"""Comparison of two campaigns, such as of two versions of a robot."""

"""Executors of genuine nodes, for an environment with rclpy."""

import rclpy
from rclpy.executors import MultiThreadedExecutor

LONGEST = 0.1  # [s] asleep


def spin(node, threads):
    """Handle the events of a node until its context ends.

    The executor of rclpy 9.1.2 may miss that a callback group is free again, or that another thread made an
    entity.X

    Args:
        node: The node.
        threads: Number of threads.
    """
    executor = MultiThreadedExecutor(num_threads=threads)
    executor.add_node(node)
    while rclpy.ok():
        executor.spin_once(timeout_sec=LONGEST)

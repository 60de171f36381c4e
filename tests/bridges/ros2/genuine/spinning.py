"""Executors of genuine nodes, for an environment with rclpy."""

import queue
from concurrent.futures import Future

import rclpy
from rclpy.executors import MultiThreadedExecutor

LONGEST = 0.1  # [s] asleep


class Spinning:
    """The executor of a node.

    The executor of rclpy 9.1.2 may miss that a callback group is free again. Then it sleeps until something else
    happens, although messages have arrived. So it never sleeps long. It may also miss an entity that another
    thread makes, or use it half-made. So other threads let the executor's thread make them.

    Args:
        node: The node.
        threads: Number of threads.
    """

    def __init__(self, node, threads):
        self._executor = MultiThreadedExecutor(num_threads=threads)
        self._executor.add_node(node)
        self._waiting = queue.SimpleQueue()

    def run(self):
        """Handle the events of the node until its context ends."""
        while rclpy.ok():
            self._executor.spin_once(timeout_sec=LONGEST)
            while not self._waiting.empty():
                self._call(*self._waiting.get())

    def call(self, function):
        """Call a function in the executor's thread, from another one, and return its result."""
        done = Future()
        self._waiting.put((function, done))
        self._executor.wake()
        return done.result()

    def _call(self, function, done):
        try:
            done.set_result(function())
        except Exception as error:
            done.set_exception(error)

"""Execution of actions: the context passed to their functions, and the driver of their coroutines."""

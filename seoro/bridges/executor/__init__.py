"""Executors, as clients reach them: what is said, finding them, and asking again when the connection was lost."""

from seoro.bridges.executor.asking import Executor, ExecutorLost
from seoro.bridges.executor.finding import ENDPOINT, find_executor, find_executors

__all__ = ["ENDPOINT", "Executor", "ExecutorLost", "find_executor", "find_executors"]

"""Node of rclpy for classes that use ROS 2 themselves.

The classes bring rclpy along: a run has a node if a loaded module has imported rclpy. The node is shared by the
actions of the run, and is spun in threads until the run ends.
"""

from __future__ import annotations

import asyncio
import sys
import threading
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from importlib import import_module
from typing import Any, Final

from seoro.bindings.plugins.calling import call_in_thread
from seoro.runtime.actions.context import ActionContext

NAME: Final = "seoro_actions"
CLOSING: Final = 10.0  # [s] beyond the grace period


async def ros_node(ctx: ActionContext) -> Any:
    """Return the node of a run, which is created for its first action; None without rclpy."""
    rclpy = sys.modules.get("rclpy")
    if rclpy is None:
        return None
    shared = ctx.shared(_Shared)
    async with shared.opening:
        if shared.node is None:
            shared.node = (await ctx.keep(_spinning(rclpy), CLOSING)).value
    return shared.node


class _Shared:
    """Node of a run."""

    def __init__(self) -> None:
        self.node: Any = None
        self.opening = asyncio.Lock()


@asynccontextmanager
async def _spinning(rclpy: Any) -> AsyncIterator[Any]:
    node, executor = await call_in_thread(lambda: _open(rclpy))
    threading.Thread(target=executor.spin, name="seoro rclpy", daemon=True).start()
    try:
        yield node
    finally:
        await call_in_thread(lambda: _close(rclpy, node, executor))


def _open(rclpy: Any) -> tuple[Any, Any]:
    """Create a node; signals stay with seoro."""
    if not rclpy.ok():
        rclpy.init(signal_handler_options=import_module("rclpy.signals").SignalHandlerOptions.NO)
    node = rclpy.create_node(NAME)
    executor = import_module("rclpy.executors").MultiThreadedExecutor()
    executor.add_node(node)
    return node, executor


def _close(rclpy: Any, node: Any, executor: Any) -> None:
    executor.shutdown()
    node.destroy_node()
    rclpy.try_shutdown()

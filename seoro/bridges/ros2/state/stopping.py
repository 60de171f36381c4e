"""Service that stops a run, for other nodes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from contextlib import AbstractAsyncContextManager
from typing import Any, Final

from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode

STOP: Final = "/seoro/stop"
TRIGGER: Final = "std_srvs/srv/Trigger"
REASON: Final = f"stopped by the service {STOP}"


def serving_stop(node: RosNode, stop: Callable[[str], bool]) -> AbstractAsyncContextManager[None]:
    """Serve the stop of a run, until the end of the block.

    Args:
        node: Serving node.
        stop: Begins to stop the run, for a reason; returns whether the run is active.
    """

    async def handle(_request: Message) -> Mapping[str, Any]:
        if stop(REASON):
            return {"success": True, "message": "the run stops its robots and cleans up"}
        return {"success": False, "message": "no run is active: it has not started, or has ended"}

    return node.serving(STOP, TRIGGER, handle)

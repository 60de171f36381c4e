"""World of an exposed simulator node, and its replacement."""

from __future__ import annotations

from seoro.concurrency.condition import Condition


class Worlds:
    """Worlds of a node: requests to expose another world, and world numbers reported by the node.

    Attributes:
        request: Number of the last request to expose another world.
    """

    def __init__(self) -> None:
        self.request = 0
        self._exposed = 0  # last request whose world is exposed
        self._number = 0
        self._changes = Condition()

    async def replace(self) -> None:
        """Request that the robots of another world are exposed, and wait until they are."""
        self.request += 1
        request = self.request
        self._changes.notify_all()
        await self._changes.wait_for(lambda: self._exposed >= request)

    def set_number(self, number: int) -> None:
        """Set the number of the present world of the node."""
        self._number = number
        self._changes.notify_all()

    async def wait_replaced(self, request: int, number: int) -> None:
        """Note that a world is exposed, and wait for another one.

        Args:
            request: Number of the last request before the world was read from the node.
            number: Number of the world at the node.
        """
        self._exposed = request
        self._changes.notify_all()
        await self._changes.wait_for(lambda: self.request > request or self._number > number)

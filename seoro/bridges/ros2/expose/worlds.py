"""Which world of a simulator node is exposed, and whether there is another one to be exposed."""

from __future__ import annotations

from seoro.changes import Changes


class Worlds:
    """The worlds of a node as those know them who load them here, and as the node tells of what others load."""

    def __init__(self) -> None:
        self._order = 0
        self._carried_out = 0
        self._told = 0
        self._changes = Changes()

    @property
    def order(self) -> int:
        """The last order to expose a world; a world that the node is asked for from now on carries it out."""
        return self._order

    async def change(self) -> None:
        """Have the robots of another world exposed, in the place of those before; waits until they are."""
        self._order += 1
        order = self._order
        self._changes.tell()
        await self._changes.wait_for(lambda: self._carried_out >= order)

    def tell(self, number: int) -> None:
        """Say which number the world has that the node has now."""
        self._told = number
        self._changes.tell()

    async def be_exposed(self, order: int, number: int) -> None:
        """Let a world be exposed until there is another.

        Args:
            order: The order that is carried out by that.
            number: The number that the world has at the node.
        """
        self._carried_out = order
        self._changes.tell()
        await self._changes.wait_for(lambda: self._order > order or self._told > number)

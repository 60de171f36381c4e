"""Which entities have begun to touch.

Things that rattle touch once: a contact is over when it has been for a while.
"""

from __future__ import annotations

from collections.abc import Iterator

from sim_nodes.stateful import Stateful

RELEASE_TIME = 0.5  # [s] apart before a contact counts as over

Pair = tuple[str, str]


class Contacts(Stateful):
    """The contacts of a world.

    Args:
        steps_per_second: Of the engine.

    Attributes:
        touching: The pairs that touched in the last step that was noted.
    """

    STATE = ("touching", "_released")

    def __init__(self, steps_per_second: int) -> None:
        self._release_steps = round(RELEASE_TIME * steps_per_second)
        self.touching: frozenset[Pair] = frozenset()
        self._released: dict[Pair, int] = {}  # pairs that have touched, and the last step in which they did

    def touches(self, name: str) -> bool:
        """Whether an entity touched something in the last step that was noted."""
        return any(name in pair for pair in self.touching)

    def note(self, touching: frozenset[Pair], step: int) -> Iterator[Pair]:
        """Take in what touches in a step; gives the pairs whose contact begins, sorted."""
        if touching == self.touching:
            return
        for pair in self.touching - touching:
            self._released[pair] = step - 1
        oldest = step - 1 - self._release_steps
        self._released = {pair: last for pair, last in self._released.items() if last >= oldest}
        begun = sorted(touching - self.touching)
        self.touching = touching
        for pair in begun:
            if self._released.pop(pair, None) is None:
                yield pair

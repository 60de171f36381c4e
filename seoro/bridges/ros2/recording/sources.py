"""What bags are read from: files of one format or the other."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from dataclasses import dataclass
from typing import Protocol

from seoro.bridges.ros2.recording.metadata import BagTopic, Extent


@dataclass(frozen=True, slots=True)
class BagMessage:
    """A message of a bag.

    Attributes:
        topic: Full name.
        payload: CDR, with its header.
        received: [ns] since the epoch, by the clock of the recorder.
        sent: [ns] since the epoch, by the clock of the sender, as far as the recorder knew.
    """

    topic: str
    payload: bytes
    received: int
    sent: int


class Source(Protocol):
    """Some files of a bag."""

    @property
    def topics(self) -> tuple[BagTopic, ...]:
        """What they have."""
        ...

    @property
    def extent(self) -> Extent:
        """How much there is."""
        ...

    @property
    def is_cut_off(self) -> bool:
        """Whether they end in the middle."""
        ...

    def messages(self, topics: Collection[str] | None, start: int) -> Iterator[BagMessage]:
        """The messages in the order in which they were received.

        Args:
            topics: Of which; all when None.
            start: [ns] since the epoch, of the first.

        Raises:
            UnreadableBag: A file is damaged.
        """
        ...

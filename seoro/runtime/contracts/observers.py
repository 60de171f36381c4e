"""Contract of observers, which receive the records of a run."""

from __future__ import annotations

from typing import Any, Protocol


class Observer(Protocol):
    """Receives every record of a run, in order. Must not block; an exception ends the run as an error."""

    def record(self, record: dict[str, Any]) -> None:
        """Receive a record, which must not be changed."""

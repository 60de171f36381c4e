"""Content of notifications."""

from __future__ import annotations

import json
from collections.abc import Mapping
from datetime import UTC, datetime
from typing import Any, Final, Literal, TypeAlias
from uuid import uuid4

from seoro import __version__

FORMAT: Final = "seoro.notification"
VERSION: Final = 1  # fields may be added within a version
Event: TypeAlias = Literal["run", "campaign", "test"]
_LONGEST: Final = 4000  # [characters] of a text


class Message:
    """A notification.

    Args:
        event: Kind of the end.
        content: Its result, as JSON data.

    Attributes:
        id: Unique id; repeated attempts have the same.
        body: The notification as JSON.
    """

    def __init__(self, event: Event, content: Mapping[str, Any]) -> None:
        self.event = event
        self.id = str(uuid4())
        data = {
            "format": FORMAT,
            "version": VERSION,
            "seoro": __version__,
            "id": self.id,
            "time": datetime.now(UTC).isoformat(timespec="milliseconds"),
            "event": event,
            event: {name: _bounded(value) for name, value in content.items()},
        }
        self.body = json.dumps(data, ensure_ascii=False, default=str).encode("utf-8", "backslashreplace")


def _bounded(value: Any) -> Any:
    return f"{value[:_LONGEST]}..." if isinstance(value, str) and len(value) > _LONGEST else value

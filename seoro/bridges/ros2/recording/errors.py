"""Errors of bags.

UsageError
|-- UnreadableBag       the bag is missing or unreadable
|-- UnknownTopic        the bag lacks a topic
`-- RefusedRecording    the recording request is invalid
BackendError
`-- RecordingFailed     the bag can no longer be written
"""

from __future__ import annotations

from seoro.errors import BackendError, UsageError


class UnreadableBag(UsageError):
    """The bag is missing or unreadable."""


class UnknownTopic(UsageError):
    """The bag lacks a topic."""


class RefusedRecording(UsageError):
    """The recording request is invalid."""


class RecordingFailed(BackendError):
    """The bag can no longer be written; earlier messages can be read."""

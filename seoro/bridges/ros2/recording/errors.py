"""Errors of bags.

UsageError
|-- UnreadableBag       the bag is missing or unreadable
|-- UnknownTopic        the bag lacks a topic
`-- RefusedRecording    the recording request is invalid
BackendError
`-- RecordingFailed     the bag can no longer be written
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from seoro.errors import BackendError, UsageError


class UnreadableBag(UsageError):
    """The bag is missing or unreadable."""


class UnknownTopic(UsageError):
    """The bag lacks a topic."""


class RefusedRecording(UsageError):
    """The recording request is invalid."""


class RecordingFailed(BackendError):
    """The bag can no longer be written; earlier messages can be read."""


@contextmanager
def unwrapped() -> Iterator[None]:
    """Raise the only exception of an exception group instead of the group."""
    try:
        yield
    except BaseExceptionGroup as group:
        error: BaseException = group
        while isinstance(error, BaseExceptionGroup) and len(error.exceptions) == 1:
            error = error.exceptions[0]
        raise error from None

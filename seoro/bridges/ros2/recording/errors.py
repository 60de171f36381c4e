"""What can go wrong with bags.

InvalidUse
|-- UnreadableBag       there is no such bag, or it cannot be read
|-- UnknownTopic        a bag does not have a topic
`-- RefusedRecording    what was asked for cannot be recorded
BackendError
`-- RecordingFailed     what is recorded can no longer be written
"""

from __future__ import annotations

from seoro.errors import BackendError, InvalidUse


class UnreadableBag(InvalidUse):
    """There is no such bag, or it cannot be read."""


class UnknownTopic(InvalidUse):
    """A bag does not have a topic."""


class RefusedRecording(InvalidUse):
    """What was asked for cannot be recorded."""


class RecordingFailed(BackendError):
    """What is recorded can no longer be written; what was written before can be read."""

"""Errors of transform lookups.

ActionFailed
`-- TransformError
    |-- UnknownFrame        the frame was never published
    |-- FramesNotConnected  the frames are in different trees, or in a cycle
    `-- OutOfReach          the transform is known at other times only
"""

from __future__ import annotations

from seoro.errors import ActionFailed


class TransformError(ActionFailed):
    """The transform between two frames is unknown."""


class UnknownFrame(TransformError):
    """The frame was never published."""


class FramesNotConnected(TransformError):
    """The frames are in different trees, or in a cycle."""


class OutOfReach(TransformError):
    """The transform is known at other times only."""

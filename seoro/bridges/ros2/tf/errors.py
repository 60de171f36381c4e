"""Why it is not known where a frame is.

ActionFailed
`-- TransformError
    |-- UnknownFrame        nobody has told of the frame
    |-- FramesNotConnected  the frames are in different trees, or in a circle
    `-- OutOfReach          there are other times at which it is known
"""

from __future__ import annotations

from seoro.errors import ActionFailed


class TransformError(ActionFailed):
    """It is not known where a frame is."""


class UnknownFrame(TransformError):
    """Nobody has told of the frame."""


class FramesNotConnected(TransformError):
    """The frames are in different trees, or in each other in a circle."""


class OutOfReach(TransformError):
    """It is known at other times only."""

"""Parameters that have a meaning for ROS 2 robots only."""

from __future__ import annotations

from seoro.errors import ActionFailed


def refuse_unless(**parameters: tuple[object, object]) -> None:
    """Refuse values that cannot be honoured where the robot lives.

    Args:
        parameters: For each name the value that was given, and the default, which asks for nothing.

    Raises:
        ActionFailed: A value is not the default.
    """
    for name, (value, default) in parameters.items():
        if value != default:
            raise ActionFailed(f"`{name}` has a meaning for robots behind a ROS 2 bridge only; leave it out here")

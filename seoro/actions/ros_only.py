"""Parameters that name parts of a ROS 2 robot, which scenarios leave to the backend: they run on any robot."""

from __future__ import annotations

from seoro.errors import ActionFailed


def refuse_unless(**parameters: tuple[object, object]) -> None:
    """Refuse parameters that only the backend can set.

    Args:
        parameters: Value and default by name.

    Raises:
        ActionFailed: A value differs from its default.
    """
    for name, (value, default) in parameters.items():
        if value != default:
            raise ActionFailed(
                f"`{name}` cannot be set in a scenario; omit it: simulators have no such names, and a bridge "
                "takes those of its robot from `--robot PROFILE:NAME@NAMESPACE` and the profile"
            )

"""Parameters that name parts of a robot of ROS 2, which a scenario does not: it runs on robots of any kind."""

from __future__ import annotations

from seoro.errors import ActionFailed


def refuse_unless(**parameters: tuple[object, object]) -> None:
    """Refuse names that the robot does not take from scenarios.

    Args:
        parameters: For each name the value that was given, and the default, which asks for nothing.

    Raises:
        ActionFailed: A value is not the default.
    """
    for name, (value, default) in parameters.items():
        if value != default:
            raise ActionFailed(
                f"`{name}` cannot be chosen here; leave it out: a simulator has no such names, and those of a "
                "robot behind a bridge are told to the bridge (`--robot PROFILE:NAME@NAMESPACE`, and its profile)"
            )

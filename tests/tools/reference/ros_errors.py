"""Error codes of ROS 2 actions, from the bundled definitions and seoro's words."""

from __future__ import annotations

from seoro.robotics import moveit_errors, nav2_errors
from tests.tools.reference.tables import code, table
from tests.tools.ros_definitions import definitions

_DISTRIBUTIONS = ("jazzy", "kilted", "lyrical")


def nav2_error_codes() -> str:
    """Return a table of the error codes in results of Nav2."""
    found: dict[tuple[int, str, str], tuple[list[str], list[str]]] = {}
    for distribution in _DISTRIBUTIONS:
        types = definitions(distribution)
        for name in types.names():
            if not name.startswith("nav2_msgs/action/"):
                continue
            action = name.rpartition("/")[2]
            for constant in types.structure(f"{name}_Result").constants:
                number = int(constant.value)
                error = nav2_errors.find_error(action, number) if number > 0 else None
                if error is not None:
                    actions, known = found.setdefault((number, *error), ([], []))
                    actions.append(action)
                    known.append(distribution)
    rows = [
        (
            str(number),
            code(name),
            "all" if number < 100 else ", ".join(sorted(set(actions))),
            ", ".join(dict.fromkeys(known)),
            words,
        )
        for (number, name, words), (actions, known) in sorted(found.items())
    ]
    return table(("code", "constant", "results of", "in", "reason"), rows)


def moveit_error_codes() -> str:
    """Return a table of the error codes of MoveIt."""
    rows = [(str(number), code(name), words) for number, (name, words) in moveit_errors.ERRORS.items()]
    return table(("code", "constant", "reason"), rows)

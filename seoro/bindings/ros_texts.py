"""Literals in scenarios that name types, topics, services and actions of ROS."""

from __future__ import annotations

from collections.abc import Mapping
from difflib import get_close_matches
from functools import partial
from typing import Final

from seoro.lang.traits import Vet
from seoro.runtime.functions.actions import RosText

_EXAMPLES: Final = {"msg": "std_msgs.msg.String", "srv": "std_srvs.srv.Trigger", "action": "nav2_msgs.action.Spin"}


def _type_problem(kind: str, text: str) -> tuple[str, str] | None:
    """Return the problem of the name of a type, and a hint; None also for packages that seoro does not know."""
    from seoro.bridges.ros2.interfaces.names import parse_name  # noqa: PLC0415 - for such literals only
    from seoro.bridges.ros2.interfaces.packages import editions  # noqa: PLC0415 - the same

    if not text:  # the type is that of the publishers
        return None
    name = parse_name(text.replace(".", "/"))
    if name is None or (name.kind or kind) != kind or name.suffix:
        return f"invalid type `{text}`", f"write it as `{_EXAMPLES[kind]}`"
    known = {each for packages in editions(name.package) for each in packages[name.package].interfaces()}
    bases = [each.partition("/")[2] for each in sorted(known) if each.startswith(f"{kind}/")]
    if not known or name.base in bases:
        return None
    close = get_close_matches(name.base, bases, n=1)
    hint = f"did you mean `{name.package}.{kind}.{close[0]}`?" if close else f"types: {', '.join(bases) or 'none'}"
    return f"`{name.package}` has no type `{name.base}`", hint


def _name_problem(text: str) -> tuple[str, str] | None:
    from seoro.bridges.ros2.wire.names import InvalidName, resolve  # noqa: PLC0415 - for such literals only

    try:
        resolve(text, "/", "node")
    except InvalidName as error:
        return str(error), error.help or "write it as `/scan`, or `scan` below the namespace"
    return None


VETS: Final[Mapping[RosText, Vet]] = {
    "msg": partial(_type_problem, "msg"),
    "srv": partial(_type_problem, "srv"),
    "action": partial(_type_problem, "action"),
    "name": _name_problem,
}
"""Checks of literals by their kind."""

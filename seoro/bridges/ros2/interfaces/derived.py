"""Derived structures of services and actions.

A definition file contains some parts (`_Request`, `_Goal`, ...). The others follow from rules of rosidl
(`rosidl_parser/definition.py`): an action is two services and one message, and every service has an event, for
introspection. Type hashes contain the names of all fields.
"""

from __future__ import annotations

from typing import Final

from seoro.bridges.ros2.interfaces.definitions import Field, Named, Scalar, Sequence, Structure
from seoro.bridges.ros2.interfaces.names import PARTS

_SERVICE: Final = ("", "_Request", "_Response", "_Event")
SUFFIXES: Final = {  # suffixes of all structures of an interface, by its kind
    "msg": ("",),
    "srv": _SERVICE,
    "action": (
        "",
        *PARTS["action"],
        *(f"_SendGoal{suffix}" for suffix in _SERVICE),
        *(f"_GetResult{suffix}" for suffix in _SERVICE),
        "_FeedbackMessage",
    ),
}
_GOAL_ID: Final = Field("goal_id", Named("unique_identifier_msgs/msg/UUID"))


def is_sent(suffix: str, kind: str) -> bool:
    """Return whether a structure is a message, and not a whole service or action."""
    return kind == "msg" or suffix not in {"", "_SendGoal", "_GetResult"}


def derive(interface: str, suffix: str) -> Structure:
    """Return a derived structure of a service or an action.

    Args:
        interface: Full name of the service or action, such as `nav2_msgs/action/Spin`.
        suffix: Suffix of the structure, such as `_SendGoal_Request`; one of `SUFFIXES` that is not in a file.
    """
    name = interface + suffix
    if "/action/" in interface and not suffix:
        return Structure(name, _action_fields(interface))
    match suffix:
        case "_SendGoal_Request":
            fields = (_GOAL_ID, Field("goal", Named(f"{interface}_Goal")))
        case "_SendGoal_Response":
            fields = (Field("accepted", Scalar("bool")), Field("stamp", Named("builtin_interfaces/msg/Time")))
        case "_GetResult_Request":
            return Structure(name, (_GOAL_ID,))
        case "_GetResult_Response":
            fields = (Field("status", Scalar("int8")), Field("result", Named(f"{interface}_Result")))
        case "_FeedbackMessage":
            fields = (_GOAL_ID, Field("feedback", Named(f"{interface}_Feedback")))
        case _:
            return Structure(name, _service_fields(name))
    return Structure(name, fields)


def _service_fields(name: str) -> tuple[Field, ...]:
    """Return the fields of a service, or of its event."""
    if name.endswith("_Event"):
        service = name.removesuffix("_Event")
        return (
            Field("info", Named("service_msgs/msg/ServiceEventInfo")),
            Field("request", Sequence(Named(f"{service}_Request"), 1)),
            Field("response", Sequence(Named(f"{service}_Response"), 1)),
        )
    return (
        Field("request_message", Named(f"{name}_Request")),
        Field("response_message", Named(f"{name}_Response")),
        Field("event_message", Named(f"{name}_Event")),
    )


def _action_fields(name: str) -> tuple[Field, ...]:
    """Return the fields of an action, which are only used for its hash."""
    return (
        Field("goal", Named(f"{name}_Goal")),
        Field("result", Named(f"{name}_Result")),
        Field("feedback", Named(f"{name}_Feedback")),
        Field("send_goal_service", Named(f"{name}_SendGoal")),
        Field("get_result_service", Named(f"{name}_GetResult")),
        Field("feedback_message", Named(f"{name}_FeedbackMessage")),
    )

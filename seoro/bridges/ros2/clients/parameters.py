"""Parameters of nodes: list, get and set them.

Types of parameters, and the members of `rcl_interfaces/msg/ParameterValue` for their values, are those of
`rcl_interfaces/msg/ParameterType`. A text is parsed as YAML, as `ros2 param set` does. Beyond that, the type of
the parameter is requested from the node: `1` becomes a double or a string if the parameter is one.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from typing import Any, Final

from seoro.bridges.ros2.clients.members import Members
from seoro.bridges.ros2.errors import NodeRefused, NoServiceServer
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.errors import UsageError
from seoro.files.plain_yaml import read_yaml

ANSWER_TIMEOUT = 10.0  # [s] for services of nodes that respond at once

NOT_SET, BOOL, INTEGER, DOUBLE, STRING, BYTE_ARRAY, BOOL_ARRAY, INTEGER_ARRAY, DOUBLE_ARRAY, STRING_ARRAY = range(
    10
)
_NAMES: Final = ("bool", "integer", "double", "string")
_MEMBERS: Final[Mapping[int, str]] = {
    **{kind: f"{name}_value" for kind, name in enumerate(_NAMES, BOOL)},
    **{kind: f"{name}_array_value" for kind, name in enumerate(("byte", *_NAMES), BYTE_ARRAY)},
}
_KINDS: Final[Mapping[type, int]] = {bool: BOOL, int: INTEGER, float: DOUBLE, str: STRING}
_ARRAYS: Final = {BOOL: BOOL_ARRAY, INTEGER: INTEGER_ARRAY, DOUBLE: DOUBLE_ARRAY, STRING: STRING_ARRAY}


def read_parameter(text: str, kind: int = NOT_SET) -> dict[str, Any]:
    """Parse a text into the members of a `rcl_interfaces/msg/ParameterValue`.

    Args:
        text: The text.
        kind: Type of the parameter; `NOT_SET` if unknown.

    Raises:
        UsageError: The text is an invalid parameter value.
    """
    value = _read(text)
    if kind == STRING and not isinstance(value, str):
        value = text
    elif kind in (DOUBLE, DOUBLE_ARRAY):
        value = _with_floats(value)
    found = _kind(value, kind)
    if found is None:
        raise UsageError(
            f"`{text}` is an invalid parameter value; expected a bool, number or text, or a list of one kind"
        )
    return {"type": found, _MEMBERS[found]: list(value) if isinstance(value, list) else value}


def _read(text: str) -> Any:
    try:
        value = read_yaml(text)
    except ValueError:
        return text
    return text if value is None else value


def _with_floats(value: Any) -> Any:
    match value:
        case bool():
            return value
        case int():
            return float(value)
        case list() if all(isinstance(item, int | float) and not isinstance(item, bool) for item in value):
            return [float(item) for item in value]
        case _:
            return value


def _kind(value: Any, known: int) -> int | None:
    if not isinstance(value, list):
        return _KINDS.get(type(value))
    if not value:
        return known if known >= BYTE_ARRAY else STRING_ARRAY
    kinds = {_KINDS.get(type(item)) for item in value}
    if kinds == {INTEGER, DOUBLE}:
        value[:] = _with_floats(value)
        return DOUBLE_ARRAY
    kind = kinds.pop() if len(kinds) == 1 else None
    if known == BYTE_ARRAY and kind == INTEGER:
        return BYTE_ARRAY
    return None if kind is None else _ARRAYS[kind]


async def set_parameter(node: RosNode, other: str, name: str, text: str) -> None:
    """Set a parameter of another node.

    Args:
        node: Requesting node.
        other: Full name of the other node.
        name: Name of the parameter.
        text: Value of the parameter.

    Raises:
        UsageError: The text is an invalid parameter value.
        NodeRefused: The node is unknown, or rejects the value; the message has the reason.
        CallFailed: The node does not respond.
    """
    declared = await _ask(node, other, "get_parameter_types", "GetParameterTypes", {"names": [name]})
    kind = int(declared.types[0]) if len(declared.types) else NOT_SET
    parameter = {"name": name, "value": read_parameter(text, kind)}
    response = await _ask(node, other, "set_parameters", "SetParameters", {"parameters": [parameter]})
    if not response.results:
        raise NodeRefused(f"{other} sent no result for the parameter `{name}`")
    result = response.results[0]
    if not result.successful:
        raise NodeRefused(f"{other} rejects `{text}` for `{name}`: {result.reason or 'no reason given'}")


async def _ask(node: RosNode, other: str, service: str, kind: str, request: Mapping[str, Any]) -> Message:
    return await call_node(node, other, service, f"rcl_interfaces/srv/{kind}", request, "parameters")


async def call_node(
    node: RosNode, other: str, service: str, type_name: str, request: Mapping[str, Any], feature: str
) -> Message:
    """Call a service of another node.

    Args:
        node: Calling node.
        other: Full name of the other node.
        service: Name of the service below that of the node.
        type_name: Type of the service.
        request: The request.
        feature: Feature that nodes with the service have, in messages.

    Raises:
        NodeRefused: The node is unknown, or lacks the service.
        CallFailed: The node does not respond.
    """
    async with node.calling(f"{other}/{service}", type_name) as client:
        try:
            await client.wait_for_server(ANSWER_TIMEOUT)
        except NoServiceServer:
            nodes = ", ".join(name for name in node.graph.nodes() if name != node.node.full_name) or "none"
            raise NodeRefused(f"no node {other} with {feature} (nodes: {nodes})") from None
        return await client.call(request, ANSWER_TIMEOUT)


async def list_parameters(node: RosNode, other: str) -> list[str]:
    """Return the names of all parameters of another node, sorted.

    Raises:
        NodeRefused: The node is unknown, or has no parameters.
        CallFailed: The node does not respond.
    """
    response = await _ask(node, other, "list_parameters", "ListParameters", {})
    return sorted(map(str, response.result.names))


async def get_parameters(node: RosNode, other: str, names: Sequence[str]) -> dict[str, Any]:
    """Return the values of parameters of another node; None for declared parameters without a value.

    Raises:
        NodeRefused: The node is unknown, or lacks one of the parameters.
        CallFailed: The node does not respond.
    """
    response = await _ask(node, other, "get_parameters", "GetParameters", {"names": list(names)})
    if len(response.values) != len(names):
        known = await list_parameters(node, other)
        unknown = next((name for name in names if name not in known), names[0])
        near = ", ".join(get_close_matches(unknown, known, n=3)) or ", ".join(known) or "none"
        raise NodeRefused(f"{other} has no parameter `{unknown}` (parameters: {near})")
    return {name: _value(value) for name, value in zip(names, response.values, strict=True)}


def _value(message: Any) -> Any:
    """Convert a `rcl_interfaces/msg/ParameterValue`."""
    member = _MEMBERS.get(int(message.type))
    return None if member is None else Members(message)[member]

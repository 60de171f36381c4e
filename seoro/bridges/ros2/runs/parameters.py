"""Parameters of a node of seoro. All are texts."""

from __future__ import annotations

import time
from collections.abc import AsyncIterator, Awaitable, Callable, Iterable, Mapping, Sequence
from contextlib import AsyncExitStack, asynccontextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Final

from seoro.bridges.ros2.clients.parameters import NOT_SET, STRING
from seoro.bridges.ros2.interfaces import Message
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.recording.bag_values import time_value
from seoro.bridges.ros2.topics import Publication
from seoro.bridges.ros2.wire import PRESETS

EVENTS: Final = "/parameter_events"

Values = dict[str, Any]


@dataclass(frozen=True)
class TextParameters:
    """Values of the parameters of a node, and the handlers of its services; each is named like its service.

    Args:
        node: Full name of the node.
        descriptions: Descriptions by the names of parameters; all begin empty.
        events: Publisher of changes.
    """

    node: str
    descriptions: Mapping[str, str]
    events: Publication
    values: dict[str, str] = field(default_factory=dict)

    def text(self, name: str) -> str:
        """Return the value of a parameter."""
        return self.values.get(name, "")

    def _value(self, name: str) -> Values:
        return {"type": STRING, "string_value": self.text(name)}

    def _known(self, names: Iterable[str]) -> list[str]:
        """Return names; none if one of them is unknown, as nodes of rclcpp and rclpy do."""
        asked = list(names)
        return asked if all(name in self.descriptions for name in asked) else []

    async def get_parameters(self, request: Message) -> Values:
        """Return values."""
        return {"values": [self._value(name) for name in self._known(request.names)]}

    async def get_parameter_types(self, request: Message) -> Values:
        """Return types."""
        return {"types": [STRING if name in self.descriptions else NOT_SET for name in request.names]}

    async def describe_parameters(self, request: Message) -> Values:
        """Return descriptions."""
        return {
            "descriptors": [
                {"name": name, "type": STRING, "description": self.descriptions[name]}
                for name in self._known(request.names)
            ]
        }

    async def list_parameters(self, request: Message) -> Values:
        """Return the names that are below the prefixes, if there are any."""
        prefixes = tuple(request.prefixes)
        names = [
            name
            for name in self.descriptions
            if not prefixes or any(name == each or name.startswith(f"{each}.") for each in prefixes)
        ]
        return {"result": {"names": names, "prefixes": []}}

    async def set_parameters(self, request: Message) -> Values:
        """Set each parameter by itself."""
        results = []
        for parameter in request.parameters:
            reason = self._refusal(parameter)
            if not reason:
                self._set([parameter])
            results.append({"successful": not reason, "reason": reason})
        return {"results": results}

    async def set_parameters_atomically(self, request: Message) -> Values:
        """Set all parameters or none."""
        reason = next(filter(None, map(self._refusal, request.parameters)), "")
        if not reason:
            self._set(request.parameters)
        return {"result": {"successful": not reason, "reason": reason}}

    def _refusal(self, parameter: Message) -> str:
        """Return why a parameter cannot be set; empty if it can."""
        if parameter.name not in self.descriptions:
            return f"unknown parameter `{parameter.name}` (parameters: {', '.join(self.descriptions)})"
        if parameter.value.type != STRING:
            return f"the parameter `{parameter.name}` is a text: quote its value"
        return ""

    def _set(self, parameters: Sequence[Message]) -> None:
        self.values.update((each.name, each.value.string_value) for each in parameters)
        changed = [{"name": each.name, "value": self._value(each.name)} for each in parameters]
        stamp = time_value(time.time_ns())
        self.events.publish({"stamp": stamp, "node": self.node, "changed_parameters": changed})


SERVICES: Final[Mapping[str, Callable[[TextParameters, Message], Awaitable[Values]]]] = {
    "GetParameters": TextParameters.get_parameters,
    "GetParameterTypes": TextParameters.get_parameter_types,
    "DescribeParameters": TextParameters.describe_parameters,
    "ListParameters": TextParameters.list_parameters,
    "SetParameters": TextParameters.set_parameters,
    "SetParametersAtomically": TextParameters.set_parameters_atomically,
}
"""Handlers by the names of types of `rcl_interfaces`."""


@asynccontextmanager
async def serving_parameters(node: RosNode, descriptions: Mapping[str, str]) -> AsyncIterator[TextParameters]:
    """Serve parameters of a node, until the end of the block.

    Args:
        node: The node.
        descriptions: Descriptions by the names of parameters.
    """
    async with AsyncExitStack() as stack:
        qos = PRESETS["parameter_events"]
        publishing = node.publishing(EVENTS, "rcl_interfaces/msg/ParameterEvent", qos)
        events = await stack.enter_async_context(publishing)
        parameters = TextParameters(node.node.full_name, descriptions, events)
        for type_name, handle in SERVICES.items():
            service, full_type = f"~/{handle.__name__}", f"rcl_interfaces/srv/{type_name}"
            await stack.enter_async_context(node.serving(service, full_type, partial(handle, parameters)))
        yield parameters

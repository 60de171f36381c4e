"""Names of ROS 2: what they may look like, and what relative and private ones mean.

The rules are those of the design article "Topic and Service name mapping to DDS" and of what ROS 2 checks itself
(rmw's validation of topic names, namespaces and node names). Names that a robot announces are not checked.
"""

from __future__ import annotations

import re

from seoro.errors import InvalidUse

LONGEST_NAME = 247  # rmw leaves this much of DDS's 255 characters
LONGEST_NODE_NAME = 255

_TOKEN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")
_TYPE = re.compile(r"[a-z][a-z0-9_]*/(?:msg|srv|action)/[A-Za-z][A-Za-z0-9_]*")


class InvalidName(InvalidUse):
    """A name that ROS 2 has no use for; the message says which part of it is wrong, and how it has to look."""


def resolve(name: str, namespace: str, node: str) -> str:
    """The full name that a name stands for in a node.

    Args:
        name: Of a topic, a service or an action: absolute (`/scan`), relative (`scan`) or private (`~/scan`).
        namespace: Of the node, absolute.
        node: Name of the node.

    Raises:
        InvalidName: It is none of these.
    """
    if not name:
        raise InvalidName("a name of a topic or service is not empty")
    if name.startswith("/"):
        full = name
    elif name.startswith("~"):
        if not name.startswith("~/"):
            raise InvalidName(f"'{name}': a private name begins with '~/', as in '~/scan'")
        full = f"{_under(namespace)}/{node}{name[1:]}"
    else:
        full = f"{_under(namespace)}/{name}"
    _check_tokens(name, full)
    if len(full) > LONGEST_NAME:
        raise InvalidName(f"'{full[:40]}...' has {len(full)} characters; names have {LONGEST_NAME} at most")
    return full


def resolve_namespace(namespace: str) -> str:
    """The absolute form of a namespace: `''` and `/` are the root, `robot1` is `/robot1`.

    Raises:
        InvalidName: It is not one.
    """
    full = "/" + namespace.strip("/")
    if full != "/":
        _check_tokens(namespace, full)
    return full


def check_node_name(name: str) -> str:
    """The name, if a node may be called that.

    Raises:
        InvalidName: It may not.
    """
    if not _TOKEN.fullmatch(name):
        raise InvalidName(f"'{name}' is no name of a node: letters, digits and '_', not beginning with a digit")
    if len(name) > LONGEST_NODE_NAME:
        raise InvalidName(f"a name of a node has {LONGEST_NODE_NAME} characters at most, not {len(name)}")
    return name


def check_type_name(name: str) -> str:
    """The name, if it is that of a message, service or action type.

    Raises:
        InvalidName: It is not.
    """
    if not _TYPE.fullmatch(name):
        raise InvalidName(f"'{name}' is no name of a type: they look like 'std_msgs/msg/String'")
    return name


def is_hidden(name: str) -> bool:
    """Whether tools list a topic or service only when asked to: a part of its name begins with `_`."""
    return any(part.startswith("_") for part in name.split("/"))


def _under(namespace: str) -> str:
    return "" if namespace == "/" else namespace


def _check_tokens(name: str, full: str) -> None:
    for token in full[1:].split("/"):
        if not token:
            raise InvalidName(f"'{name}': there is nothing between or after its slashes")
        if "{" in token or "}" in token:
            raise InvalidName(f"'{name}': substitutions such as '{{ns}}' are not carried out; write the name out")
        if not _TOKEN.fullmatch(token):
            raise InvalidName(
                f"'{name}': '{token}' has to be letters, digits and '_', and not to begin with a digit"
            )

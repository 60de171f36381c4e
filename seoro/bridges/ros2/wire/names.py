"""Validation and resolution of ROS 2 names.

The rules are those of the design article "Topic and Service name mapping to DDS", and of the validation in rmw of
topic names, namespaces and node names. Names that a robot announces are not checked.
"""

from __future__ import annotations

import re

from seoro.errors import UsageError

MAX_NAME = 247  # [characters]; the limit of rmw, below the 255 of DDS
MAX_NODE_NAME = 255  # [characters]

_TOKEN = re.compile(r"[A-Za-z_][A-Za-z0-9_]*")


class InvalidName(UsageError):
    """A name is invalid in ROS 2; the message has the invalid part, and the expected form."""


def resolve(name: str, namespace: str, node: str) -> str:
    """Return the full name of a topic, service or action in a node.

    Args:
        name: Absolute (`/scan`), relative (`scan`) or private (`~/scan`) name.
        namespace: Absolute namespace of the node.
        node: Name of the node.

    Raises:
        InvalidName: The name is invalid.
    """
    if not name:
        raise InvalidName("empty name of a topic or service")
    if name.startswith("/"):
        full = name
    elif name.startswith("~"):
        if not name.startswith("~/"):
            raise InvalidName(f"'{name}': private names begin with '~/', as in '~/scan'")
        full = f"{_under(namespace)}/{node}{name[1:]}"
    else:
        full = f"{_under(namespace)}/{name}"
    _check_tokens(name, full)
    if len(full) > MAX_NAME:
        raise InvalidName(f"'{full[:40]}...' has {len(full)} characters; names have {MAX_NAME} at most")
    return full


def resolve_namespace(namespace: str) -> str:
    """Return the absolute form of a namespace: `''` and `/` are the root, `robot1` is `/robot1`.

    Raises:
        InvalidName: The namespace is invalid.
    """
    full = "/" + namespace.strip("/")
    if full != "/":
        _check_tokens(namespace, full)
    return full


def check_node_name(name: str) -> str:
    """Check the name of a node, and return it.

    Raises:
        InvalidName: The name is invalid.
    """
    if not _TOKEN.fullmatch(name):
        raise InvalidName(f"invalid node name '{name}': expected letters, digits and '_', with no digit first")
    if len(name) > MAX_NODE_NAME:
        raise InvalidName(f"the node name has {len(name)} characters; node names have {MAX_NODE_NAME} at most")
    return name


def is_hidden(name: str) -> bool:
    """Return whether a topic or service is hidden: a part of its name begins with `_`."""
    return any(part.startswith("_") for part in name.split("/"))


def _under(namespace: str) -> str:
    return "" if namespace == "/" else namespace


def _check_tokens(name: str, full: str) -> None:
    for token in full[1:].split("/"):
        if not token:
            raise InvalidName(f"'{name}': empty part between or after slashes")
        if "{" in token or "}" in token:
            raise InvalidName(f"'{name}': substitutions such as '{{ns}}' are unsupported; write the name out")
        if not _TOKEN.fullmatch(token):
            raise InvalidName(
                f"'{name}': invalid part '{token}': expected letters, digits and '_', no digit first"
            )

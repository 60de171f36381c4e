"""Key expressions of requests, and liveliness tokens of nodes."""

from __future__ import annotations

import hashlib
import re
from functools import partial

MAJOR = 1
NAMESPACE = "default"  # namespace of nodes and executors without another

_CHUNK = re.compile(r"[a-z0-9_-]+")


def _chunk(text: str) -> str:
    """Return a name as a chunk of a key expression; only names that need no escaping are allowed."""
    if not _CHUNK.fullmatch(text):
        raise ValueError(f"invalid name {text!r} of a node; expected lower-case letters, digits, '_' and '-'")
    return text


def _command(kind: str, namespace: str, name: str, verb: str) -> str:
    return f"seoro/{MAJOR}/{_chunk(namespace)}/{kind}/{_chunk(name)}/cmd/{verb if verb == '*' else _chunk(verb)}"


def _token(kind: str, namespace: str, name: str, boot: str) -> str:
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/{kind}/{_chunk(name)}/{_chunk(boot)}"


def _tokens(kind: str, namespace: str) -> str:
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/{kind}/*/*"


def _tokens_of(kind: str, namespace: str, name: str) -> str:
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/{kind}/{_chunk(name)}/*"


def _any_tokens(kind: str, namespace: str) -> str:
    return f"seoro/*/{_chunk(namespace)}/alive/{kind}/*/*"


node_command, executor_command = partial(_command, "node"), partial(_command, "exec")
"""Keys of requests to a node or an executor by namespace, name and verb; the verb `*` stands for all."""

node_token, executor_token = partial(_token, "node"), partial(_token, "exec")
"""Liveliness tokens of a node or an executor by namespace, name and boot, the id of a start of its process."""

node_tokens, executor_tokens = partial(_tokens, "node"), partial(_tokens, "exec")
"""Key expressions of the tokens of all nodes or executors of a namespace."""

node_tokens_of, executor_tokens_of = partial(_tokens_of, "node"), partial(_tokens_of, "exec")
"""Key expressions of the tokens of the nodes or executors of a namespace and a name."""

any_node_tokens, any_executor_tokens = partial(_any_tokens, "node"), partial(_any_tokens, "exec")
"""Key expressions of the tokens of all nodes or executors of a namespace, of any version of the protocol."""


def verb_of(key: str) -> str:
    """Return the name of the verb in the key of a request."""
    return key.rpartition("/")[2]


def node_stream(namespace: str, node: str, stream: str) -> str:
    """Key on which a node publishes an open stream."""
    return f"seoro/{MAJOR}/{_chunk(namespace)}/node/{_chunk(node)}/st/{_chunk(stream)}"


def token_node(key: str) -> tuple[str, str]:
    """Return the node and the boot in the key of a liveliness token."""
    *_, node, boot = key.split("/")
    return node, boot


def token_major(key: str) -> str:
    """Return the major version of the protocol in the key of a liveliness token."""
    return key.split("/")[1]


def holder_token(namespace: str, holder: str) -> str:
    """Liveliness token of a client that holds robots.

    The name of the client permits moving its robots, and tokens are visible to all. So the token has a hash of it.
    """
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/holder/{public_holder_name(holder)}"


def public_holder_name(holder: str) -> str:
    """Return the hash of the name of a client, which is shown to others."""
    return hashlib.sha256(holder.encode()).hexdigest()[:32]


def holder_tokens(namespace: str) -> str:
    """Key expression of the tokens of all holders."""
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/holder/*"


def emergency_key(namespace: str) -> str:
    """Key on which an emergency stop is published to all nodes and executors."""
    return f"seoro/{MAJOR}/{_chunk(namespace)}/estop"

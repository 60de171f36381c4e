"""Key expressions: on which a node is asked, and which tell that it lives."""

from __future__ import annotations

import hashlib
import re

MAJOR = 1
NAMESPACE = "default"  # that of everything that nobody has put into another

_CHUNK = re.compile(r"[a-z0-9_-]+")


def _chunk(text: str) -> str:
    """A chunk of a key expression; only names that need no escaping are allowed."""
    if not _CHUNK.fullmatch(text):
        raise ValueError(f"{text!r} cannot name a node: use lower-case letters, digits, '_' and '-'")
    return text


def _command(namespace: str, kind: str, name: str, verb: str) -> str:
    return f"seoro/{MAJOR}/{_chunk(namespace)}/{kind}/{_chunk(name)}/cmd/{verb if verb == '*' else _chunk(verb)}"


def _token(namespace: str, kind: str, name: str, boot: str) -> str:
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/{kind}/{_chunk(name)}/{_chunk(boot)}"


def _tokens(namespace: str, kind: str) -> str:
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/{kind}/*/*"


def verb_of(key: str) -> str:
    """Return the name of the verb that a key of commands ends with."""
    return key.rpartition("/")[2]


def node_command(namespace: str, node: str, verb: str) -> str:
    """Key on which a node is asked to carry out a verb; `verb` may be `*` for all."""
    return _command(namespace, "node", node, verb)


def node_stream(namespace: str, node: str, stream: str) -> str:
    """Key on which a node publishes a stream that it was asked for."""
    return f"seoro/{MAJOR}/{_chunk(namespace)}/node/{_chunk(node)}/st/{_chunk(stream)}"


def node_token(namespace: str, node: str, boot: str) -> str:
    """Liveliness token of a node; `boot` tells one start of it from the next."""
    return _token(namespace, "node", node, boot)


def node_tokens(namespace: str) -> str:
    """Key expression of the tokens of all nodes."""
    return _tokens(namespace, "node")


def node_tokens_of(namespace: str, node: str) -> str:
    """Key expression of the tokens of the nodes of one name."""
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/node/{_chunk(node)}/*"


def any_node_tokens(namespace: str) -> str:
    """Key expression of the tokens of all nodes, whatever version of the protocol they speak."""
    return f"seoro/*/{_chunk(namespace)}/alive/node/*/*"


def token_node(key: str) -> tuple[str, str]:
    """Node and boot of a liveliness token's key."""
    *_, node, boot = key.split("/")
    return node, boot


def holder_token(namespace: str, holder: str) -> str:
    """Liveliness token of a client that holds robots.

    It has not the name of the client, by which robots may be moved, but one that follows from that: everybody may
    look at tokens.
    """
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/holder/{shown_holder(holder)}"


def shown_holder(holder: str) -> str:
    """What a client is called before everybody."""
    return hashlib.sha256(holder.encode()).hexdigest()[:32]


def holder_tokens(namespace: str) -> str:
    """Key expression of the tokens of all holders."""
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/holder/*"


def executor_command(namespace: str, executor: str, verb: str) -> str:
    """Key on which an executor is asked to carry out a verb; `verb` may be `*` for all."""
    return _command(namespace, "exec", executor, verb)


def executor_token(namespace: str, executor: str, boot: str) -> str:
    """Liveliness token of an executor; `boot` tells one start of it from the next."""
    return _token(namespace, "exec", executor, boot)


def executor_tokens(namespace: str) -> str:
    """Key expression of the tokens of all executors."""
    return _tokens(namespace, "exec")


def executor_tokens_of(namespace: str, executor: str) -> str:
    """Key expression of the tokens of the executors of one name."""
    return f"seoro/{MAJOR}/{_chunk(namespace)}/alive/exec/{_chunk(executor)}/*"


def any_executor_tokens(namespace: str) -> str:
    """Key expression of the tokens of all executors, whatever version of the protocol they speak."""
    return f"seoro/*/{_chunk(namespace)}/alive/exec/*/*"


def token_major(key: str) -> str:
    """Major version of the protocol of whoever has declared a liveliness token."""
    return key.split("/")[1]


def emergency_key(namespace: str) -> str:
    """Key on which an emergency stop is published, to all at once who have something that moves."""
    return f"seoro/{MAJOR}/{_chunk(namespace)}/estop"

"""Challenges of executors and nodes with keys, and result codes of authentication.

A node with keys accepts three kinds of requests. Public ones change nothing (`Verb.is_public`). Others name a
client that holds robots, with a code of this client (`seoro.security.signing.answers`). All others are signed
(`seoro.security.signing.commands`) by a client with a sufficient role.
"""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import ConfigDict, Field

from seoro.bridges.wire.limits import KIBIBYTE, SMALL, Limits
from seoro.bridges.wire.message import Message, Query
from seoro.security.keys.roles import Role

# Result codes of refusals by servers with keys.
UNAVAILABLE: Final = 101  # of executors: a later attempt may succeed
DENIED: Final = 102  # the keys or the role of the client do not permit the request
STALE: Final = 103  # the request must be signed again, after a challenge


class Challenge(Message):
    """Challenge of an executor or a node to prove its name."""

    model_config = ConfigDict(defer_build=True)

    nonce: Annotated[bytes, Field(min_length=16, max_length=16)]  # random


class Proof(Message):
    """Proof of identity (`seoro.security.signing.commands`), and data for signed requests."""

    model_config = ConfigDict(defer_build=True)

    certificate: bytes
    signature: bytes
    boot: str  # start of the process
    now: int  # [ns] since 1970, by its clock
    exchange: bytes = b""  # public key of this start, for authentic answers (`seoro.security.signing.answers`)


class Claim(Message):
    """Age of an executor, sent to another executor of its name; the younger one gives up the name."""

    model_config = ConfigDict(defer_build=True)

    boot: str  # start of the process
    age: Annotated[int, Field(ge=0)]  # [ns] since then, by the monotonic clock
    signature: bytes = b""  # of a statement with the nonce (`seoro.security.signing`); empty without keys


CHALLENGE = Query("challenge", Challenge, Proof, Limits(KIBIBYTE, 16), SMALL, role=Role.VIEWER)
CLAIM = Query("claim", Challenge, Claim, Limits(KIBIBYTE, 16), SMALL, role=Role.EXECUTOR)


def has_signature(attachment: bytes) -> bool:
    """Whether the attachment of a request is a signature; names of clients begin with another byte."""
    return attachment[:1] == b"\x95"  # msgpack's for a list of five

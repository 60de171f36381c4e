"""Proving who one is: what executors and nodes with keys answer to a challenge, and which requests need a seal.

To a node with keys, a request is one of three: it changes nothing; it has the name of a client that holds robots
there beside it, with a code that only this client can make (`seoro.keys.answers`); or it is sealed
(`seoro.keys.sealing`) by somebody whose role may ask for it.
"""

from __future__ import annotations

from typing import Annotated, Final

from pydantic import ConfigDict, Field

from seoro.bridges.wire.limits import KIBIBYTE, SMALL, Limits
from seoro.bridges.wire.message import Message, Verb

UNAVAILABLE: Final = 101  # the code of a refusal by an executor: whoever asks again later will have an answer
DENIED: Final = 102  # the code of a refusal: the keys of who asks, or their role, do not allow it
STALE: Final = 103  # the code of a refusal: what was sealed has to be sealed anew, after a challenge


class Challenge(Message):
    """Asks an executor or a node to prove that it is the one of its name."""

    model_config = ConfigDict(defer_build=True)

    nonce: Annotated[bytes, Field(min_length=16, max_length=16)]  # drawn for this


class Proof(Message):
    """What proves it (`seoro.keys.sealing`), and what seals for it need."""

    model_config = ConfigDict(defer_build=True)

    certificate: bytes
    signature: bytes
    boot: str  # which start of it this is
    now: int  # [ns] since 1970, by its clock
    exchange: bytes = b""  # public key of this start, for authentic answers (`seoro.keys.answers`)


class Claim(Message):
    """Says how long an executor has had its name; to another one of that name, which may have to give it up."""

    model_config = ConfigDict(defer_build=True)

    boot: str  # which start of it this is
    age: Annotated[int, Field(ge=0)]  # [ns] since then, by a clock that nobody sets
    signature: bytes = (
        b""  # by its key, with what the challenger has drawn (`seoro.keys.signing`); empty without keys
    )


CHALLENGE = Verb("challenge", Challenge, Proof, Limits(KIBIBYTE, 16), SMALL)
CLAIM = Verb("claim", Challenge, Claim, Limits(KIBIBYTE, 16), SMALL)

_ALWAYS: Final = frozenset({"take_robots", "lease_robots", "release_lease", "emergency_stop", "release_stop"})
_READING: Final = "get_"  # begins what changes nothing
# Those of clients that hold robots have the name of the client in them, and the code of this client beside them.
_NEVER: Final = frozenset({"challenge", "hold_robots", "release_robots"})


def is_open(verb: str) -> bool:
    """Whether nodes answer a request without knowing whose it is."""
    return verb.startswith(_READING) or verb in _NEVER


def is_sealed(verb: str) -> bool:
    """Whether a request to a node has to be sealed, whoever holds robots there."""
    return verb in _ALWAYS


def has_seal(attachment: bytes) -> bool:
    """Whether what is beside a request is a seal; names of clients do not begin so."""
    return attachment[:1] == b"\x95"  # msgpack's for a list of five

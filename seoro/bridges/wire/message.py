"""Base class of messages, which are pydantic models sent as msgpack maps, and the class of verbs."""

from __future__ import annotations

from dataclasses import KW_ONLY, field
from typing import Any, Generic, TypeVar

import msgpack
from pydantic import BaseModel, ConfigDict, ValidationError

from seoro.bridges.wire.limits import ANSWER, SMALL, LimitExceeded, Limits, check_limits
from seoro.deferred import dataclass
from seoro.security.keys.roles import Role

SHOWN = 3  # errors of a message that are listed
LONGEST = 300  # [characters] of each of them
MAX_PENDING = 1024  # requests without a reply at a server


class Message(BaseModel):
    """Base of everything that crosses a process boundary."""

    model_config = ConfigDict(frozen=True, extra="ignore", defer_build=True)


M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
A = TypeVar("A", bound=Message)


class WireError(Exception):
    """A payload is not a valid message."""


def encode(message: Message) -> bytes:
    """Encode a message with msgpack."""
    packed: bytes = msgpack.packb(message.model_dump(mode="python"), default=_plain)
    return packed


def _plain(value: Any) -> Any:
    if isinstance(value, tuple | frozenset | set):
        return list(value)
    raise TypeError(f"unsupported type in a message: {type(value).__name__}")


def decode(kind: type[M], payload: bytes, limits: Limits = SMALL) -> M:
    """Check the limits of a payload and decode it; the only function that decodes messages.

    Args:
        kind: Model of the message.
        payload: Encoded message.
        limits: Limits, checked before anything is decoded.

    Raises:
        WireError: The payload exceeds the limits, is not msgpack, or does not fit the model.
    """
    try:
        check_limits(payload, limits)
        return kind.model_validate(msgpack.unpackb(payload, strict_map_key=True))
    except LimitExceeded as error:
        raise WireError(f"{kind.__name__} exceeds a limit: {error}") from None
    except ValidationError as error:
        raise WireError(f"not a valid {kind.__name__}: {_describe_errors(error)}") from None
    except (ValueError, msgpack.UnpackException) as error:
        raise WireError(f"not a valid {kind.__name__}: {str(error)[:LONGEST]}") from error


def _describe_errors(error: ValidationError) -> str:
    """List the first errors without the invalid values, which may be large and come from an unknown sender."""
    found = error.errors(include_url=False, include_context=False, include_input=False)
    shown = [f"{'.'.join(map(str, each['loc'])) or 'message'}: {each['msg']}"[:LONGEST] for each in found[:SHOWN]]
    more = f"; and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return "; ".join(shown) + more


class Empty(Message):
    """Message without fields."""


class TrackedRequest(Message):
    """Request of a goal or a watch, whose end is reported as the `Occurrence` with its id."""

    id: str


@dataclass(frozen=True, eq=False)  # each verb is declared once, and compared by identity
class Verb(Generic[Q, A]):
    """Kind of request to a node or an executor: its messages, limits and permissions.

    Handlers, clients, permission checks and the reference page of the protocol are derived from it.

    Attributes:
        name: Name of the verb, the last part of the key of a request.
        request: Model of the request.
        reply: Model of the reply.
        limits: Limits of a request, checked before its sender is known.
        reply_limits: Limits of a reply.
        role: Lowest role that may send it.
        is_read_only: Whether it changes nothing; nodes then accept it without proof of the sender.
        is_audited: Whether it is signed, and recorded in the audit log.
        is_stop: Whether it stops something; exempt from rate limits and from failures of the audit log.
        is_urgent: Whether request and reply overtake all other messages.
        names_holder: Whether it names a holder of robots, whose code beside the request proves the sender.
        waits: Whether its reply may wait for events.
        max_pending: Number of its requests that may wait for a reply at a server.
    """

    name: str
    request: type[Q]
    reply: type[A]
    limits: Limits = SMALL
    reply_limits: Limits = ANSWER
    _: KW_ONLY
    role: Role = Role.OPERATOR
    is_read_only: bool = False
    is_audited: bool = False
    is_stop: bool = False
    is_urgent: bool = False
    names_holder: bool = False
    waits: bool = False
    max_pending: int = MAX_PENDING

    @property
    def is_public(self) -> bool:
        """Whether nodes with keys accept a request without a signature."""
        return self.is_read_only or self.names_holder

    def pack(self, request: Q) -> bytes:
        """Encode a request.

        Raises:
            LimitExceeded: The request is larger than the server accepts.
        """
        payload = encode(request)
        if len(payload) > self.limits.size:
            raise LimitExceeded(
                f"the request `{self.name}` has {len(payload)} bytes; expected at most {self.limits.size}"
            )
        return payload

    def read(self, payload: bytes) -> Q:
        """Decode a request.

        Raises:
            WireError: The request is invalid, or exceeds the limits.
        """
        return decode(self.request, payload, self.limits)

    def read_reply(self, payload: bytes) -> A:
        """Decode a reply.

        Raises:
            WireError: The reply is invalid, or exceeds the limits.
        """
        return decode(self.reply, payload, self.reply_limits)


@dataclass(frozen=True, eq=False)
class Query(Verb[Q, A]):
    """Verb that changes nothing."""

    is_read_only: bool = field(default=True, kw_only=True)

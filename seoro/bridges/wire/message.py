"""What every message is: a pydantic model that travels as a msgpack map, and what verbs are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import msgpack
from pydantic import BaseModel, ConfigDict, ValidationError

from seoro.bridges.wire.limits import ANSWER, SMALL, LimitExceeded, Limits, check_limits

SHOWN = 3  # mistakes of a message that are named
LONGEST = 300  # [characters] of each


class Message(BaseModel):
    """Base of everything that crosses a process boundary."""

    model_config = ConfigDict(frozen=True, extra="ignore")


M = TypeVar("M", bound=Message)
Q = TypeVar("Q", bound=Message)
A = TypeVar("A", bound=Message)


class WireError(Exception):
    """A payload that is not the message it should be."""


def encode(message: Message) -> bytes:
    """The msgpack form of a message."""
    packed: bytes = msgpack.packb(message.model_dump(mode="python"), default=_plain)
    return packed


def _plain(value: Any) -> Any:
    if isinstance(value, tuple | frozenset | set):
        return list(value)
    raise TypeError(f"{type(value).__name__} does not go over the wire")


def decode(kind: type[M], payload: bytes, limits: Limits = SMALL) -> M:
    """Decode a payload, which keeps its limits; the only place where messages are decoded.

    Args:
        kind: Model of the message.
        payload: Its bytes.
        limits: What it may have. They are checked before anything is decoded.

    Raises:
        WireError: The payload exceeds the limits, is no msgpack, or does not fit the model.
    """
    try:
        check_limits(payload, limits)
        return kind.model_validate(msgpack.unpackb(payload, strict_map_key=True))
    except LimitExceeded as error:
        raise WireError(f"{kind.__name__} exceeds a limit: {error}") from None
    except ValidationError as error:
        raise WireError(f"not a valid {kind.__name__}: {_mistakes(error)}") from None
    except (ValueError, msgpack.UnpackException) as error:
        raise WireError(f"not a valid {kind.__name__}: {str(error)[:LONGEST]}") from error


def _mistakes(error: ValidationError) -> str:
    """Name the first mistakes, without what was found there: that may be large, and is of somebody unknown."""
    found = error.errors(include_url=False, include_context=False, include_input=False)
    shown = [f"{'.'.join(map(str, each['loc'])) or 'message'}: {each['msg']}"[:LONGEST] for each in found[:SHOWN]]
    more = f"; and {len(found) - SHOWN} more" if len(found) > SHOWN else ""
    return "; ".join(shown) + more


class Empty(Message):
    """Nothing to say."""


@dataclass(frozen=True)
class Verb(Generic[Q, A]):
    """One thing a node can be asked.

    Attributes:
        name: In the key.
        request: Model of the request.
        answer: Model of the answer.
        limits: Of a request. They hold before it is known who sends it.
        answers: Limits of an answer.
        is_urgent: Whether request and answer overtake everything else on their way.
    """

    name: str
    request: type[Q]
    answer: type[A]
    limits: Limits = SMALL
    answers: Limits = ANSWER
    is_urgent: bool = False

    def pack(self, request: Q) -> bytes:
        """Encode a request.

        Raises:
            LimitExceeded: It is larger than whoever serves the verb accepts.
        """
        payload = encode(request)
        if len(payload) > self.limits.size:
            raise LimitExceeded(
                f"the request `{self.name}` has {len(payload)} bytes: at most {self.limits.size} are accepted"
            )
        return payload

    def read(self, payload: bytes) -> Q:
        """Decode a request.

        Raises:
            WireError: It is invalid, or exceeds the limits.
        """
        return decode(self.request, payload, self.limits)

    def read_answer(self, payload: bytes) -> A:
        """Decode an answer.

        Raises:
            WireError: It is invalid, or exceeds the limits.
        """
        return decode(self.answer, payload, self.answers)

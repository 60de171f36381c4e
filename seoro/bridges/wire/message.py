"""What every message is: a pydantic model that travels as a msgpack map, and what verbs are."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Generic, TypeVar

import msgpack
from pydantic import BaseModel, ConfigDict, ValidationError

MAX_MESSAGE = 64 * 1024 * 1024  # [bytes]; larger payloads are refused unread


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


def decode(kind: type[M], payload: bytes) -> M:
    """The message in a payload.

    Raises:
        WireError: The payload is too large, is no msgpack, or does not fit the model.
    """
    if len(payload) > MAX_MESSAGE:
        raise WireError(f"{kind.__name__} of {len(payload)} bytes exceeds the limit of {MAX_MESSAGE}")
    try:
        return kind.model_validate(msgpack.unpackb(payload, strict_map_key=True))
    except (ValueError, msgpack.UnpackException, ValidationError) as error:
        raise WireError(f"not a valid {kind.__name__}: {error}") from error


class Empty(Message):
    """Nothing to say."""


@dataclass(frozen=True)
class Verb(Generic[Q, A]):
    """One thing a node can be asked: the name in the key, the models of request and answer."""

    name: str
    request: type[Q]
    answer: type[A]

"""Authentic answers: each is bound to its request, and to the executor or node that was asked.

Who asks draws a key pair, and an executor or a node draws one at each start; its public key is in the signed proof
of who it is. Both sides derive a secret from these (X25519), which nobody between them knows. Answers carry a code
that is made with it: BLAKE2b with a key. (HMAC takes 20 µs if nothing of it is in the processor's cache, as is so
between two steps of a simulation.) An answer to one who has no such secret is signed.
"""

from __future__ import annotations

import hashlib
import hmac
import os
from collections.abc import Callable
from functools import cache
from itertools import count
from typing import Final, NamedTuple, TypeAlias

import msgpack
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey, X25519PublicKey

from seoro.keys.errors import InvalidKeys
from seoro.keys.folder import Keys
from seoro.keys.roles import Role
from seoro.keys.signing import Signatures, digest, sign

ENVELOPE: Final = b"\x94"  # how what is beside a request begins whose answer has to be authentic: a list of four
_ANSWER: Final = "seoro answer 1"
_SHARED: Final = "seoro answers 1"
_CODE: Final = 32  # [bytes] of a code
_MOST_SECRETS: Final = 1000  # that are remembered; others are derived again

Attest: TypeAlias = Callable[[bytes, int, int, bytes], bytes]
"""Returns what makes an answer authentic, from the request, the form of the answer, its number, and the answer."""


class _KeyPair:
    """A key pair that lasts as long as its process; for any thread."""

    def __init__(self) -> None:
        self._private = X25519PrivateKey.generate()
        self._known: dict[tuple[bytes, str, bytes], bytes] = {}
        self.public: Final = self._private.public_key().public_bytes_raw()
        self.numbers: Final = count(1)  # of the requests to which it belongs, each of which has its own

    def secret(self, public: bytes, boot: str, asking: bytes) -> bytes:
        """The secret that is shared with the owner of another public key.

        Args:
            public: The other public key.
            boot: Start of the executor or node.
            asking: Public key of who asks: one of both.

        Raises:
            ValueError: It is no usable public key.
        """
        known = self._known.get((public, boot, asking))
        if known is None:
            shared = self._private.exchange(X25519PublicKey.from_public_bytes(public))
            known = hmac.digest(shared, digest(_SHARED, boot, asking), "sha256")
            if len(self._known) >= _MOST_SECRETS:
                self._known.clear()
            self._known[public, boot, asking] = known
        return known


@cache
def _pair_of(_process: int) -> _KeyPair:
    """The key pair by which a process asks; one that is forked has its own."""
    return _KeyPair()


def _code(secret: bytes, key: str, request: bytes, beside: bytes, form: int, number: int, answer: bytes) -> bytes:
    """The code of an answer; without a secret, its hash."""
    head = digest(_ANSWER, key, form, number, len(request), len(beside))  # which says where it ends itself
    code = hashlib.blake2b(head, key=secret, digest_size=_CODE)
    for each in (request, beside, answer):
        code.update(each)
    return code.digest()


class Answers:
    """Makes the answers of an executor or a node authentic; for any thread.

    Args:
        keys: Of the executor or node.
        boot: Its start.
    """

    def __init__(self, keys: Keys, boot: str) -> None:
        self._keys = keys
        self._boot = boot
        self._pair = _KeyPair()

    @property
    def exchange(self) -> bytes:
        """The public key of this start."""
        return self._pair.public

    def open(self, key: str, beside: bytes) -> tuple[bytes, Attest | None]:
        """Split what is beside a request: returns the seal or name of who asks, and what attests answers.

        Args:
            key: Key of the request.
            beside: What came beside it. If it asks for no authentic answer, it is returned as it is.
        """
        if not beside.startswith(ENVELOPE):
            return beside, None
        try:
            public, boot, _, inner = msgpack.unpackb(beside)
            if type(public) is not bytes or type(inner) is not bytes:
                raise TypeError
        except (ValueError, TypeError, msgpack.UnpackException):
            return beside, None

        def attest(request: bytes, form: int, number: int, answer: bytes) -> bytes:
            secret = self._secret(public) if boot == self._boot else b""  # derived after the request was admitted
            code = _code(secret, key, request, beside, form, number, answer)
            parts = (form, number, code, b"") if secret else (form, number, b"", sign(self._keys, _ANSWER, code))
            packed: bytes = msgpack.packb(parts)
            return packed

        return inner, attest

    def _secret(self, public: bytes) -> bytes:
        """The secret that is shared with who asks; empty if there can be none."""
        try:
            return self._pair.secret(public, self._boot, public)
        except ValueError:
            return b""


class Checked(NamedTuple):
    """What an authentic answer says of itself.

    Attributes:
        form: Its form.
        number: Of the answer among those to the same request, from 0 on.
        is_signed: Whether it is signed, since no secret was shared when it was sent.
    """

    form: int
    number: int
    is_signed: bool


Check: TypeAlias = Callable[[bytes, bytes], Checked]
"""Checks an answer and what came beside it; raises `InvalidKeys` if another has answered, or it was changed."""


class Checker:
    """Checks the answers of an executor or a node.

    Args:
        keys: Of who asks.
        name: Of the executor or node.
        role: Which of both it is.
    """

    def __init__(self, keys: Keys, name: str, role: Role) -> None:
        self._name = name
        self._role = role
        self._pair = _pair_of(os.getpid())
        self._signatures = Signatures(keys.authority)
        self._boot = ""
        self._secret = b""

    def share(self, boot: str, exchange: bytes) -> None:
        """Share a secret with a start of the executor or node.

        Args:
            boot: The start.
            exchange: Its public key, as it has signed it.

        Raises:
            InvalidKeys: It is no public key.
        """
        try:
            self._secret = self._pair.secret(exchange, boot, self._pair.public)
        except ValueError as error:
            raise InvalidKeys("the key for its answers is invalid") from error
        self._boot = boot

    def prepare(self, key: str, request: bytes, inner: bytes) -> tuple[bytes, Check]:
        """Return what goes beside a request, and what checks its answers.

        Args:
            key: Key of the request.
            request: The request.
            inner: Its seal, or the name of who asks.
        """
        secret = self._secret
        beside: bytes = msgpack.packb([self._pair.public, self._boot, next(self._pair.numbers), inner])

        def check(answer: bytes, attested: bytes) -> Checked:
            form, number, code, signature = _parts(attested)
            expected = _code(secret if code else b"", key, request, beside, form, number, answer)
            if not code:
                self._signatures.check(signature, self._role, self._name, _ANSWER, expected)
            elif not (secret and hmac.compare_digest(code, expected)):
                raise InvalidKeys("the signature is wrong: it was changed on its way, or is not by whom it names")
            return Checked(form, number, not code)

        return beside, check


def _parts(attested: bytes) -> tuple[int, int, bytes, bytes]:
    if not attested:
        raise InvalidKeys("it is not signed")
    try:
        form, number, code, signature = msgpack.unpackb(attested)
    except (ValueError, TypeError, msgpack.UnpackException) as error:
        raise InvalidKeys(f"its signature is invalid: {error}") from error
    if not (type(form) is type(number) is int and type(code) is type(signature) is bytes):
        raise InvalidKeys("its signature is invalid")
    return form, number, code, signature

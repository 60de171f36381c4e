"""Authentic answers and requests: an answer is bound to its request, and to the executor or node that was asked.

Who asks draws a key pair, and an executor or a node draws one at each start; its public key is in the signed proof
of who it is. Both sides derive a secret from these (X25519), which nobody between them knows. Answers carry a code
that is made with it: BLAKE2b with a key. (HMAC takes 20 µs if nothing of it is in the processor's cache, as is so
between two steps of a simulation.) An answer to one who has no such secret is signed.

Requests of a client that holds robots carry a code, too, made with the same secret. The public key of the client
is in the sealed request by which it took the robots.
"""

from __future__ import annotations

import hashlib
import hmac
import os
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from itertools import count
from typing import Final, NamedTuple, TypeAlias

import msgpack
from cryptography.hazmat.primitives.asymmetric.x25519 import X25519PrivateKey, X25519PublicKey

from seoro.keys.certificates import Identity
from seoro.keys.errors import InvalidKeys
from seoro.keys.folder import Keys
from seoro.keys.revoked_file import RevokedFile
from seoro.keys.roles import Role
from seoro.keys.signing import Signatures, digest, sign
from seoro.keys.window import HolderKey

ENVELOPE: Final = b"\x94"  # how what is beside a request begins whose answer has to be authentic: a list of four
_ANSWER: Final = "seoro answer 1"
_REQUEST: Final = "seoro request 1"
_SHARED: Final = "seoro answers 1"
_CODE: Final = 32  # [bytes] of a code
_MOST_SECRETS: Final = 1000  # that are remembered; others are derived again


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
def _own_pair() -> _KeyPair:
    """Return the key pair by which this process asks."""
    return _KeyPair()


os.register_at_fork(after_in_child=_own_pair.cache_clear)  # ids of processes may repeat: sandboxes count their own


def _code(secret: bytes, key: str, request: bytes, beside: bytes, form: int, number: int, answer: bytes) -> bytes:
    """The code of an answer; without a secret, its hash."""
    head = digest(_ANSWER, key, form, number, len(request), len(beside))  # which says where it ends itself
    code = hashlib.blake2b(head, key=secret, digest_size=_CODE)
    for each in (request, beside, answer):
        code.update(each)
    return code.digest()


def _request_code(secret: bytes, key: str, number: int, inner: bytes, request: bytes) -> bytes:
    """The code of a request of a client that holds robots."""
    code = hashlib.blake2b(digest(_REQUEST, key, number, inner), key=secret, digest_size=_CODE)
    code.update(request)
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

    def open(self, key: str, beside: bytes) -> tuple[bytes, Envelope | None]:
        """Split what is beside a request: returns the seal or name of who asks, and the envelope around it.

        Args:
            key: Key of the request.
            beside: What came beside it. If it asks for no authentic answer, it is returned as it is.
        """
        if not beside.startswith(ENVELOPE):
            return beside, None
        try:
            public, boot, (number, code), inner = msgpack.unpackb(beside)
            if not (type(public) is type(code) is type(inner) is bytes and type(number) is int):
                raise TypeError
        except (ValueError, TypeError, msgpack.UnpackException):
            return beside, None
        return inner, Envelope(self, key, beside, public, boot, number, code, inner)

    def sign(self, code: bytes) -> bytes:
        """The signature of an answer, by its hash."""
        return sign(self._keys, _ANSWER, code)

    def secret(self, public: bytes, boot: str) -> bytes:
        """The secret that is shared with a client; empty if there can be none.

        Args:
            public: Public key of the client.
            boot: The start that the client has asked.
        """
        if boot != self._boot:
            return b""
        try:
            return self._pair.secret(public, self._boot, public)
        except ValueError:
            return b""


@dataclass(slots=True)
class Envelope:
    """Numbered envelope of a request, which has the public key of the client."""

    _answers: Answers
    _key: str
    _beside: bytes
    _public: bytes
    _boot: str
    _number: int
    _code: bytes
    _inner: bytes
    _accepted: HolderKey | None = field(default=None, init=False)

    def attest(self, request: bytes, form: int, number: int, answer: bytes) -> bytes:
        """Return what makes an answer authentic.

        Args:
            request: The request.
            form: Form of the answer.
            number: Of the answer among those to the same request, from 0 on.
            answer: The answer.
        """
        secret = self._answers.secret(self._public, self._boot)  # derived after the request was admitted
        code = _code(secret, self._key, request, self._beside, form, number, answer)
        parts = (form, number, code, b"") if secret else (form, number, b"", self._answers.sign(code))
        packed: bytes = msgpack.packb(parts)
        return packed

    def check(self, holder: HolderKey, request: bytes) -> None:
        """Check that a client that holds robots has sent a request; accepts the number of the request once.

        Args:
            holder: Key of the client.
            request: The request.

        Raises:
            InvalidKeys: Another has sent the request, it was changed, or it was sent before.
        """
        if self._accepted is holder:
            return
        secret = self._answers.secret(self._public, self._boot) if self._public == holder.exchange else b""
        expected = _request_code(secret, self._key, self._number, self._inner, request) if secret else b""
        if not (expected and hmac.compare_digest(self._code, expected)):
            raise InvalidKeys("its code is wrong or missing")
        if not holder.window.accept(self._number):
            raise InvalidKeys("it was sent before, or too late")
        self._accepted = holder


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
        self._pair = _own_pair()
        self._revoked = RevokedFile(keys)
        self._signatures = Signatures(keys.authority, self._revoked.current)
        self._boot = ""
        self._secret = b""
        self._peer: Identity | None = None  # that has the secret, too

    def share(self, peer: Identity, boot: str, exchange: bytes) -> None:
        """Share a secret with a start of the executor or node.

        Args:
            peer: By which identity it has proved who it is.
            boot: The start.
            exchange: Its public key, as it has signed it.

        Raises:
            InvalidKeys: It is no public key.
        """
        try:
            self._secret = self._pair.secret(exchange, boot, self._pair.public)
        except ValueError as error:
            raise InvalidKeys("the key for its answers is invalid") from error
        self._boot, self._peer = boot, peer

    def holder_key(self) -> tuple[bytes, int]:
        """Return the public key of this client, and a number that is lower than those of all later requests."""
        return self._pair.public, next(self._pair.numbers)

    def prepare(self, key: str, request: bytes, inner: bytes, *, has_code: bool = False) -> tuple[bytes, Check]:
        """Return what goes beside a request, and what checks its answers.

        Args:
            key: Key of the request.
            request: The request.
            inner: Its seal, or the name of who asks.
            has_code: Whether to add a code that authenticates the sender, in place of a seal.
        """
        secret, peer, asked = self._secret, self._peer, next(self._pair.numbers)
        code = _request_code(secret, key, asked, inner, request) if has_code and secret else b""
        beside: bytes = msgpack.packb([self._pair.public, self._boot, (asked, code), inner])

        def check(answer: bytes, attested: bytes) -> Checked:
            form, number, code, signature = _parts(attested)
            expected = _code(secret if code else b"", key, request, beside, form, number, answer)
            if not code:
                self._signatures.check(signature, self._role, self._name, _ANSWER, expected)
            elif peer is None or not hmac.compare_digest(code, expected):
                raise InvalidKeys("the signature is wrong: it was changed on its way, or is not by whom it names")
            else:
                self._revoked.check(peer)
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

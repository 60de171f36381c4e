"""Authenticated answers and requests: an answer is bound to its request and to the executor or node that sent it.

The client generates a key pair; an executor or a node generates one at each start, and includes its public key in
the signed proof of its name. Both sides derive a shared secret (X25519), which routers between them cannot know.
Answers carry a code made with the secret: BLAKE2b with a key. (HMAC takes 20 µs with a cold cache, as between two
steps of a simulation.) An answer to a client without a shared secret is signed.

Requests of a client that holds robots carry such a code, too. The public key of the client is in the signed
request by which it took the robots.
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

from seoro.security.keys.certificates import Identity
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.folder import Keys
from seoro.security.keys.revocation import RevokedFile
from seoro.security.keys.roles import Role
from seoro.security.signing.replay_window import HolderKey
from seoro.security.signing.statements import INVALID_SIGNATURE, StatementVerifier, digest, sign

ENVELOPE: Final = b"\x94"  # first byte of an attachment that requests an authenticated answer: a list of four
_ANSWER: Final = "seoro answer 1"
_REQUEST: Final = "seoro request 1"
_SHARED: Final = "seoro answers 1"
_CODE: Final = 32  # [bytes] of a code
_MOST_SECRETS: Final = 1000  # cached secrets; others are derived again


class _KeyPair:
    """Key pair of a process; for any thread."""

    def __init__(self) -> None:
        self._private = X25519PrivateKey.generate()
        self._known: dict[tuple[bytes, str, bytes], bytes] = {}
        self.public: Final = self._private.public_key().public_bytes_raw()
        self.numbers: Final = count(1)  # of requests of this key pair, each used once

    def secret(self, public: bytes, boot: str, asking: bytes) -> bytes:
        """Return the secret that is shared with the owner of another public key.

        Args:
            public: The other public key.
            boot: Identifier of the start of the executor or node.
            asking: Public key of the client, one of the two.

        Raises:
            ValueError: The public key is invalid.
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
    """Return the key pair of this process as a client."""
    return _KeyPair()


os.register_at_fork(after_in_child=_own_pair.cache_clear)  # ids of processes may repeat: sandboxes count their own


def _code(
    secret: bytes, key: str, request: bytes, attachment: bytes, form: int, number: int, answer: bytes
) -> bytes:
    """Return the code of an answer; without a secret, its hash."""
    head = digest(_ANSWER, key, form, number, len(request), len(attachment))  # msgpack delimits itself
    code = hashlib.blake2b(head, key=secret, digest_size=_CODE)
    for each in (request, attachment, answer):
        code.update(each)
    return code.digest()


def _request_code(secret: bytes, key: str, number: int, inner: bytes, request: bytes) -> bytes:
    """Return the code of a request of a client that holds robots."""
    code = hashlib.blake2b(digest(_REQUEST, key, number, inner), key=secret, digest_size=_CODE)
    code.update(request)
    return code.digest()


class AnswerSigner:
    """Authenticates the answers of an executor or a node; for any thread.

    Args:
        keys: Keys of the executor or node.
        boot: Identifier of its start.
    """

    def __init__(self, keys: Keys, boot: str) -> None:
        self._keys = keys
        self._boot = boot
        self._pair = _KeyPair()
        self.exchange: Final = self._pair.public  # public key of this start

    def open(self, key: str, attachment: bytes) -> tuple[bytes, Envelope | None]:
        """Split the attachment of a request into the signature or name of the client, and its envelope.

        Args:
            key: Key of the request.
            attachment: The attachment; returned as it is if it has no envelope.
        """
        if not attachment.startswith(ENVELOPE):
            return attachment, None
        try:
            public, boot, (number, code), inner = msgpack.unpackb(attachment)
            if not (type(public) is type(code) is type(inner) is bytes and type(number) is int):
                raise TypeError
        except (ValueError, TypeError, msgpack.UnpackException):
            return attachment, None
        return inner, Envelope(self, key, attachment, public, boot, number, code, inner)

    def sign(self, code: bytes) -> bytes:
        """Sign the hash of an answer."""
        return sign(self._keys, _ANSWER, code)

    def secret(self, public: bytes, boot: str) -> bytes:
        """Return the secret that is shared with a client; empty if its key or `boot` is not valid.

        Args:
            public: Public key of the client.
            boot: Identifier of the start that the client has challenged.
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

    _answers: AnswerSigner
    _key: str
    _beside: bytes
    _public: bytes
    _boot: str
    _number: int
    _code: bytes
    _inner: bytes
    _accepted: HolderKey | None = field(default=None, init=False)

    def attest(self, request: bytes, form: int, number: int, answer: bytes) -> bytes:
        """Return the attachment that authenticates an answer.

        Args:
            request: The request.
            form: Form of the answer.
            number: Index of the answer among those to the same request.
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
            InvalidKeys: The request was changed, repeated, or sent by another client.
        """
        if self._accepted is holder:
            return
        secret = self._answers.secret(self._public, self._boot) if self._public == holder.exchange else b""
        expected = _request_code(secret, self._key, self._number, self._inner, request) if secret else b""
        if not (expected and hmac.compare_digest(self._code, expected)):
            raise InvalidKeys("its code is invalid or missing")
        if not holder.window.accept(self._number):
            raise InvalidKeys("it was received before, or too late")
        self._accepted = holder


class Checked(NamedTuple):
    """Properties of a verified answer.

    Attributes:
        form: Form of the answer.
        number: Index of the answer among those to the same request.
        is_signed: Whether it is signed, because no secret was shared when it was sent.
    """

    form: int
    number: int
    is_signed: bool


Check: TypeAlias = Callable[[bytes, bytes], Checked]
"""Verifies an answer with its attachment; raises `InvalidKeys` for changed answers and other senders."""


class AnswerVerifier:
    """Verifies the answers of an executor or a node.

    Args:
        keys: Keys of the client.
        name: Name of the executor or node.
        role: Role of the executor or node.
    """

    def __init__(self, keys: Keys, name: str, role: Role) -> None:
        self._name = name
        self._role = role
        self._pair = _own_pair()
        self._revoked = RevokedFile(keys)
        self._signatures = StatementVerifier(keys.authority, self._revoked.current)
        self._boot = ""
        self._secret = b""
        self._peer: Identity | None = None  # owner of the secret at the other side

    def share(self, peer: Identity, boot: str, exchange: bytes) -> None:
        """Derive the secret that is shared with a start of the executor or node.

        Args:
            peer: Proven identity of the executor or node.
            boot: Identifier of its start.
            exchange: Its public key, from the signed proof.

        Raises:
            InvalidKeys: The public key is invalid.
        """
        try:
            self._secret = self._pair.secret(exchange, boot, self._pair.public)
        except ValueError as error:
            raise InvalidKeys("invalid public key for its answers") from error
        self._boot, self._peer = boot, peer

    def holder_key(self) -> tuple[bytes, int]:
        """Return the public key of this client, and a number below those of all later requests."""
        return self._pair.public, next(self._pair.numbers)

    def prepare(self, key: str, request: bytes, inner: bytes, *, has_code: bool = False) -> tuple[bytes, Check]:
        """Return the attachment of a request, and the function that verifies its answers.

        Args:
            key: Key of the request.
            request: The request.
            inner: Signature, or name of the client.
            has_code: Whether to add a code that authenticates the client in place of a signature.
        """
        secret, peer, asked = self._secret, self._peer, next(self._pair.numbers)
        code = _request_code(secret, key, asked, inner, request) if has_code and secret else b""
        attachment: bytes = msgpack.packb([self._pair.public, self._boot, (asked, code), inner])

        def check(answer: bytes, attested: bytes) -> Checked:
            form, number, code, signature = _parts(attested)
            expected = _code(secret if code else b"", key, request, attachment, form, number, answer)
            if not code:
                self._signatures.check(signature, self._role, self._name, _ANSWER, expected)
            elif peer is None or not hmac.compare_digest(code, expected):
                raise InvalidKeys(INVALID_SIGNATURE)
            else:
                self._revoked.check(peer)
            return Checked(form, number, not code)

        return attachment, check


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

"""The log of what was asked of an executor or a node: signed lines of JSON, each with the hash of the one before.

Whoever changes a line, takes one out of the middle or puts one in breaks the chain. Lines that are taken off the
end leave no trace but in copies: whoever wants to be sure keeps the number and the hash of a last line elsewhere.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from base64 import b64decode, b64encode
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final

from cryptography import x509
from cryptography.exceptions import InvalidSignature
from cryptography.hazmat.primitives import hashes
from cryptography.hazmat.primitives.asymmetric import ec

from seoro.durable import sync_folder
from seoro.input_files import Kind, open_input
from seoro.keys.certificates import check_issued, identity_of
from seoro.keys.errors import InvalidKeys
from seoro.keys.folder import Keys
from seoro.keys.reserve import reserve
from seoro.keys.roles import Role
from seoro.keys.signing import certificate_der

WRITERS: Final = frozenset({Role.EXECUTOR, Role.NODE})
_ALGORITHM: Final = ec.ECDSA(hashes.SHA256())
_NOTHING: Final = "0" * 64  # the hash of the line before the first
_LONGEST: Final = 1 << 20  # [bytes] of a line
RESERVE: Final = 1 << 16  # [bytes] of the disk that emergency stops always have


class Audit:
    """Writes a log, which goes on where it was.

    Room for emergency stops is reserved behind its end: a full disk keeps out all other lines before them.

    Args:
        path: Its file.
        keys: Of the executor or the node.

    Raises:
        OSError: It cannot be written.
    """

    def __init__(self, path: Path, keys: Keys) -> None:
        self._keys = keys
        self._file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o600), "r+b", buffering=0)
        whole, last = _last_line(path)
        self._file.truncate(whole)  # what was half written when an executor died is no line
        self._file.seek(whole)
        self._reserved = whole  # up to which byte there is room that nobody else gets
        self._number = 0 if last is None else int(json.loads(last)["number"]) + 1
        self._previous = _NOTHING if last is None else hashlib.sha256(last).hexdigest()
        certificate = b64encode(certificate_der(keys.certificate)).decode()
        self.write(what=_started(keys.identity.role), by=keys.identity.name, certificate=certificate)
        self.sync()
        sync_folder(path.absolute().parent)

    def write(self, *, is_urgent: bool = False, **entry: Any) -> int:
        """Write a line.

        Args:
            is_urgent: Whether it may use the room that is reserved.
            entry: What it says, as JSON has it.

        Returns:
            Its number.

        Raises:
            OSError: It could not be written.
        """
        said = {"number": self._number, "time": round(time.time(), 6), **entry, "previous": self._previous}
        signature = self._keys.key.sign(_signed(said), _ALGORITHM)
        line = json.dumps({**said, "signature": b64encode(signature).decode()}).encode() + b"\n"
        at = self._file.tell()
        if not is_urgent:
            self._reserve(at, at + len(line) + RESERVE)
        try:
            if self._file.write(line) != len(line):
                raise OSError("the disk is full")
        except OSError:
            self._file.truncate(at)
            self._file.seek(at)
            raise
        self._number += 1
        self._previous = hashlib.sha256(line).hexdigest()
        return self._number - 1

    def sync(self) -> None:
        """Force all lines to the disk; blocks.

        Raises:
            OSError: That cannot be done.
        """
        os.fdatasync(self._file.fileno())

    def _reserve(self, at: int, end: int) -> None:
        """Reserve room up to a byte, and somewhat more if there is any, so as not to do it for each line.

        Raises:
            OSError: There is no room.
        """
        if end <= self._reserved:
            return
        for each in (end + RESERVE, end):
            try:
                reserve(self._file.fileno(), at, each - at)
            except OSError:
                if each == end:
                    raise
            else:
                self._reserved = each
                return

    def close(self) -> None:
        """Write nothing any more."""
        self._file.close()


@dataclass(frozen=True)
class Checked:
    """A log that holds.

    Attributes:
        count: How many lines it has.
        last: Hash of the last line.
        writers: Whose logs they are.
    """

    count: int
    last: str
    writers: tuple[str, ...]


def check_log(path: Path, authority: x509.Certificate) -> Checked:
    """Check that nothing in a log was changed, taken out or put in.

    Raises:
        InvalidKeys: Something was, or it is no log.
    """
    previous, public, number = _NOTHING, None, -1
    writers: dict[str, None] = {}
    for number, line in enumerate(_lines(path)):
        where = f"{path}:{number + 1}"
        try:
            said = json.loads(line)
            signature = b64decode(said.pop("signature"), validate=True)
            if said["what"] in map(_started, Role):
                public, name = _writer(b64decode(said["certificate"], validate=True), authority)
                writers[name] = None
            if public is None:
                raise InvalidKeys("the line with the certificate of who writes is missing before it")
            public.verify(signature, _signed(said), _ALGORITHM)
            if said["number"] != number or said["previous"] != previous:
                raise InvalidKeys("lines before it are missing, or were changed")
        except InvalidSignature:
            raise InvalidKeys(f"{where}: the line was changed, or was not written by whose log it is") from None
        except InvalidKeys as error:
            raise InvalidKeys(f"{where}: {error}") from None
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise InvalidKeys(f"{where}: it is no line of such a log") from error
        previous = hashlib.sha256(line).hexdigest()
    return Checked(number + 1, previous, tuple(writers))


def _started(role: Role) -> str:
    """What the first line of each start says."""
    return f"{role.value} started"


def _writer(data: bytes, authority: x509.Certificate) -> tuple[ec.EllipticCurvePublicKey, str]:
    certificate = x509.load_der_x509_certificate(data)
    check_issued(certificate, authority)
    identity, public = identity_of(certificate), certificate.public_key()
    if identity.role not in WRITERS or not isinstance(public, ec.EllipticCurvePublicKey):
        raise InvalidKeys(f"{identity} is neither an executor nor a node")
    return public, identity.name


def _signed(said: dict[str, Any]) -> bytes:
    return json.dumps(said, sort_keys=True, separators=(",", ":")).encode()


def _lines(path: Path) -> Iterator[bytes]:
    try:
        with open_input(path, Kind.AUDIT) as file:
            while line := file.readline(_LONGEST):
                yield line
    except OSError as error:
        raise InvalidKeys(f"cannot read {path}: {error.strerror}") from error


def _last_line(path: Path) -> tuple[int, bytes | None]:
    """How many bytes of a log are whole lines, and the last of them."""
    size = path.stat().st_size
    with open_input(path, Kind.AUDIT) as file:
        start = max(size - 2 * _LONGEST, 0)
        file.seek(start)
        data = file.read()
    whole = data[: data.rfind(b"\n") + 1]
    if not whole:
        return 0, None
    return start + len(whole), whole[whole.rfind(b"\n", 0, -1) + 1 :]

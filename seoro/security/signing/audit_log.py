"""Audit log of an executor or a node: signed lines of JSON, each with the hash of the previous line.

Changing, removing or inserting a line breaks the chain. Removing lines at the end is not detected: to detect it,
keep the number and the hash of the last line elsewhere.
"""

from __future__ import annotations

import ctypes
import errno
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

from seoro.files.durable import sync_folder
from seoro.files.inputs import Kind, open_input
from seoro.security.keys.certificates import check_issued, identity_of
from seoro.security.keys.errors import InvalidKeys
from seoro.security.keys.folder import Keys
from seoro.security.keys.roles import Role
from seoro.security.signing.statements import certificate_der

WRITERS: Final = frozenset({Role.EXECUTOR, Role.NODE})
_ALGORITHM: Final = ec.ECDSA(hashes.SHA256())
_NOTHING: Final = "0" * 64  # previous hash of the first line
_LONGEST: Final = 1 << 20  # [bytes] of a line
_KEEP_SIZE: Final = 1  # of Linux's fallocate: the size of the file stays
_UNSUPPORTED: Final = frozenset({errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL, errno.ENODEV})
RESERVE: Final = 1 << 16  # [bytes] of the disk reserved for emergency stops


class AuditLog:
    """Appends lines to a log.

    Disk space for emergency stops is reserved after its end: on a full disk, all other lines fail before them.

    Args:
        path: File of the log.
        keys: Keys of the executor or node.

    Raises:
        OSError: The log cannot be written.
    """

    def __init__(self, path: Path, keys: Keys) -> None:
        self._keys = keys
        self._file = os.fdopen(os.open(path, os.O_RDWR | os.O_CREAT, 0o600), "r+b", buffering=0)
        whole, last = _last_line(path)
        self._file.truncate(whole)  # drop a line that was written in part when the executor died
        self._file.seek(whole)
        self._reserved = whole  # end of the reserved disk space
        self._number = 0 if last is None else int(json.loads(last)["number"]) + 1
        self._previous = _NOTHING if last is None else hashlib.sha256(last).hexdigest()
        certificate = b64encode(certificate_der(keys.certificate)).decode()
        self.write(what=_started(keys.identity.role), by=keys.identity.name, certificate=certificate)
        self.sync()
        sync_folder(path.absolute().parent)

    def write(self, *, is_urgent: bool = False, **entry: Any) -> int:
        """Write a line.

        Args:
            is_urgent: Whether it may use the reserved disk space.
            entry: Fields of the line, as JSON.

        Returns:
            The number of the line.

        Raises:
            OSError: The line could not be written.
        """
        entry = {"number": self._number, "time": round(time.time(), 6), **entry, "previous": self._previous}
        signature = self._keys.key.sign(_signed(entry), _ALGORITHM)
        line = json.dumps({**entry, "signature": b64encode(signature).decode()}).encode() + b"\n"
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
            OSError: Writing to the disk failed.
        """
        os.fdatasync(self._file.fileno())

    def _reserve(self, at: int, end: int) -> None:
        """Reserve disk space up to a byte, and somewhat more if possible, to do it less often.

        Raises:
            OSError: The disk is full.
        """
        if end <= self._reserved:
            return
        for each in (end + RESERVE, end):
            try:
                _fallocate(self._file.fileno(), at, each - at)
            except OSError:
                if each == end:
                    raise
            else:
                self._reserved = each
                return

    def close(self) -> None:
        """Close the file."""
        self._file.close()


@dataclass(frozen=True)
class Checked:
    """Summary of a valid log.

    Attributes:
        count: Number of lines.
        last: Hash of the last line.
        writers: Names of the executors and nodes that wrote it.
    """

    count: int
    last: str
    writers: tuple[str, ...]


def check_log(path: Path, authority: x509.Certificate) -> Checked:
    """Check that no line of a log was changed, removed or inserted.

    Raises:
        InvalidKeys: A line is invalid; names it.
    """
    previous, public, number = _NOTHING, None, -1
    writers: dict[str, None] = {}
    for number, line in enumerate(_lines(path)):
        where = f"{path}:{number + 1}"
        try:
            entry = json.loads(line)
            signature = b64decode(entry.pop("signature"), validate=True)
            if entry["what"] in map(_started, Role):
                public, name = _writer(b64decode(entry["certificate"], validate=True), authority)
                writers[name] = None
            if public is None:
                raise InvalidKeys("missing line with the certificate of the writer before it")
            public.verify(signature, _signed(entry), _ALGORITHM)
            if entry["number"] != number or entry["previous"] != previous:
                raise InvalidKeys("lines before it are missing or changed")
        except InvalidSignature:
            raise InvalidKeys(f"{where}: invalid signature: the line was changed or has another writer") from None
        except InvalidKeys as error:
            raise InvalidKeys(f"{where}: {error}") from None
        except (ValueError, KeyError, TypeError, AttributeError) as error:
            raise InvalidKeys(f"{where}: invalid line of an audit log") from error
        previous = hashlib.sha256(line).hexdigest()
    return Checked(number + 1, previous, tuple(writers))


def _started(role: Role) -> str:
    """Return the event of the first line of each start."""
    return f"{role.value} started"


def _writer(data: bytes, authority: x509.Certificate) -> tuple[ec.EllipticCurvePublicKey, str]:
    certificate = x509.load_der_x509_certificate(data)
    check_issued(certificate, authority)
    identity, public = identity_of(certificate), certificate.public_key()
    if identity.role not in WRITERS or not isinstance(public, ec.EllipticCurvePublicKey):
        raise InvalidKeys(f"invalid writer {identity}; expected an executor or a node")
    return public, identity.name


def _signed(entry: dict[str, Any]) -> bytes:
    return json.dumps(entry, sort_keys=True, separators=(",", ":")).encode()


def _lines(path: Path) -> Iterator[bytes]:
    try:
        with open_input(path, Kind.AUDIT) as file:
            while line := file.readline(_LONGEST):
                yield line
    except OSError as error:
        raise InvalidKeys(f"cannot read {path}: {error.strerror}") from error


def _last_line(path: Path) -> tuple[int, bytes | None]:
    """Return the number of bytes in whole lines, and the last whole line."""
    size = path.stat().st_size
    with open_input(path, Kind.AUDIT) as file:
        start = max(size - 2 * _LONGEST, 0)
        file.seek(start)
        data = file.read()
    whole = data[: data.rfind(b"\n") + 1]
    if not whole:
        return 0, None
    return start + len(whole), whole[whole.rfind(b"\n", 0, -1) + 1 :]


def _fallocate(descriptor: int, start: int, length: int) -> bool:
    """Reserve disk space for a part of a file, possibly after its end; the content stays.

    Args:
        descriptor: Descriptor of the file, open for writing.
        start: Start of the part [bytes].
        length: Length of the part [bytes].

    Returns:
        Whether the system and the file system support it.

    Raises:
        OSError: The disk is full.
    """
    fallocate = getattr(ctypes.CDLL(None, use_errno=True), "fallocate64", None)
    if fallocate is None:
        return False
    fallocate.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.c_int64, ctypes.c_int64)
    if fallocate(descriptor, _KEEP_SIZE, start, length) == 0:
        return True
    error = ctypes.get_errno()
    if error in _UNSUPPORTED:
        return False
    raise OSError(error, os.strerror(error))

"""Files of keys: atomic writes with strict permissions, and reads with clear errors."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec

from seoro.files.inputs import Kind, read_input
from seoro.security.keys.certificates import PrivateKey
from seoro.security.keys.errors import InvalidKeys


def make_folder(folder: Path) -> None:
    """Make a folder that only its owner can read.

    Raises:
        InvalidKeys: The folder cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        folder.chmod(0o700)
    except OSError as error:
        raise InvalidKeys(f"cannot create the folder {folder}: {error.strerror}") from error


def write_private(path: Path, data: bytes) -> None:
    """Write a file that only its owner can read, atomically."""
    _write(path, data, 0o600)


def write_public(path: Path, data: bytes) -> None:
    """Write a file that everyone may read, atomically."""
    _write(path, data, 0o644)


def _write(path: Path, data: bytes, mode: int) -> None:
    half = path.with_name(f".{path.name}.{os.getpid()}")
    try:
        with suppress(FileNotFoundError):
            half.unlink()
        with os.fdopen(os.open(half, os.O_WRONLY | os.O_CREAT | os.O_EXCL, mode), "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        half.replace(path)
    except OSError as error:
        half.unlink(missing_ok=True)
        raise InvalidKeys(f"cannot write {path}: {error.strerror}") from error


def read_file(path: Path) -> bytes:
    """Read a file.

    Raises:
        InvalidKeys: The file cannot be read.
    """
    try:
        return read_input(path, Kind.KEYS)
    except OSError as error:
        raise InvalidKeys(f"cannot read {path}: {error.strerror}") from error


def read_certificate(path: Path) -> x509.Certificate:
    """Read a certificate.

    Raises:
        InvalidKeys: The file is missing or contains no certificate.
    """
    try:
        return x509.load_pem_x509_certificate(read_file(path))
    except ValueError as error:
        raise InvalidKeys(f"invalid certificate: {path}") from error


def read_pair(key: Path, certificate: Path) -> tuple[PrivateKey, x509.Certificate]:
    """Read a private key and its certificate.

    Raises:
        InvalidKeys: A file is missing or invalid, others can read the key, or the two do not match.
    """
    pair = _read_key(key), read_certificate(certificate)
    if pair[0].public_key() != pair[1].public_key():
        raise InvalidKeys(f"{key} does not match {certificate}")
    return pair


def _read_key(path: Path) -> PrivateKey:
    """Read a private key, whose file only the owner may read."""
    data = read_file(path)
    if path.stat().st_mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise InvalidKeys(
            f"other users can read the private key {path}",
            help=f"run `chmod 600 {path}`; if another user may have read it, revoke the identity",
        )
    try:
        key = serialization.load_pem_private_key(data, password=None)
    except (ValueError, TypeError) as error:
        raise InvalidKeys(f"invalid private key: {path}") from error
    if not isinstance(key, ec.EllipticCurvePrivateKey) or not isinstance(key.curve, ec.SECP256R1):
        raise InvalidKeys(f"unsupported kind of key: {path}", help="create keys by `seoro keys add`")
    return key

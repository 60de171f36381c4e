"""Files of keys: private ones for nobody else, and read with a clear message when they cannot be."""

from __future__ import annotations

import os
import stat
from contextlib import suppress
from pathlib import Path

from cryptography import x509
from cryptography.hazmat.primitives import serialization
from cryptography.hazmat.primitives.asymmetric import ec

from seoro.input_files import Kind, read_input
from seoro.keys.certificates import PrivateKey
from seoro.keys.errors import InvalidKeys


def make_folder(folder: Path) -> None:
    """Have a folder that nobody else can look into.

    Raises:
        InvalidKeys: It cannot be made.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True, mode=0o700)
        folder.chmod(0o700)
    except OSError as error:
        raise InvalidKeys(f"cannot keep keys in {folder}: {error.strerror}") from error


def write_private(path: Path, data: bytes) -> None:
    """Write a file that nobody else can read, whole or not at all."""
    _write(path, data, 0o600)


def write_public(path: Path, data: bytes) -> None:
    """Write a file that others may read, whole or not at all."""
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
    """The content of a file.

    Raises:
        InvalidKeys: It cannot be read.
    """
    try:
        return read_input(path, Kind.KEYS)
    except OSError as error:
        raise InvalidKeys(f"cannot read {path}: {error.strerror}") from error


def read_certificate(path: Path) -> x509.Certificate:
    """The certificate in a file.

    Raises:
        InvalidKeys: There is none.
    """
    try:
        return x509.load_pem_x509_certificate(read_file(path))
    except ValueError as error:
        raise InvalidKeys(f"{path} is no certificate") from error


def read_pair(key: Path, certificate: Path) -> tuple[PrivateKey, x509.Certificate]:
    """A private key, and the certificate that belongs to it.

    Raises:
        InvalidKeys: One of them is not there, others can read the key, or they do not belong together.
    """
    pair = _read_key(key), read_certificate(certificate)
    if pair[0].public_key() != pair[1].public_key():
        raise InvalidKeys(f"{key} does not belong to {certificate}")
    return pair


def _read_key(path: Path) -> PrivateKey:
    """The private key in a file that nobody else can read."""
    data = read_file(path)
    if path.stat().st_mode & (stat.S_IRWXG | stat.S_IRWXO):
        raise InvalidKeys(
            f"{path} is private, and others can read it",
            help=f"`chmod 600 {path}`; if somebody may have read it, revoke it and make another",
        )
    try:
        key = serialization.load_pem_private_key(data, password=None)
    except (ValueError, TypeError) as error:
        raise InvalidKeys(f"{path} is no private key") from error
    if not isinstance(key, ec.EllipticCurvePrivateKey) or not isinstance(key.curve, ec.SECP256R1):
        raise InvalidKeys(f"{path} is a key of another kind", help="`seoro keys add` makes keys")
    return key

"""Socket, addresses, certificate and rights of a site."""

from __future__ import annotations

import contextlib
import errno
import ipaddress
import socket
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Final

from seoro.errors import UsageError
from seoro.security.keys.folder import chosen_folder, default_folder, read_keys
from seoro.security.keys.roles import PEOPLE, Role
from seoro.ui.security import Access

if TYPE_CHECKING:
    from seoro.security.keys.folder import KeyFolder

LOOPBACK: Final = "127.0.0.1"
_HERE: Final = (LOOPBACK, "localhost")


@dataclass(frozen=True)
class Address:
    """Address of a site.

    Args:
        host: Host name or address, without brackets.
        port: Port; 0 for a free one.
    """

    host: str = LOOPBACK
    port: int = 0

    @property
    def is_local(self) -> bool:
        """Whether only this machine reaches it."""
        try:
            return ipaddress.ip_address(self.host).is_loopback
        except ValueError:
            return self.host == "localhost"

    def __str__(self) -> str:
        return f"{_in_url(self.host)}:{self.port}"


def parse_address(text: str) -> Address:
    """Convert `HOST:PORT`.

    Raises:
        UsageError: The text is invalid, or names no single host.
    """
    host, colon, port = text.rpartition(":")
    host = host.removeprefix("[").removesuffix("]")
    if not colon or not host or not port.isdecimal() or int(port[:6]) > 65_535:
        raise UsageError(f"invalid address `{text}`: expected HOST:PORT", help="such as lab-pc.example.org:7480")
    with contextlib.suppress(ValueError):
        if ipaddress.ip_address(host).is_unspecified:
            raise UsageError(
                f"invalid host `{host}`: browsers need a name or an address of this machine",
                help="such as lab-pc.example.org:7480",
            )
    return Address(host, int(port))


@dataclass(frozen=True)
class Endpoint:
    """Open socket of a site.

    Args:
        listener: The socket.
        access: Its addresses, with new secrets.
        certificate: Folder with its certificate; None without TLS.
        role: Role of the person whose rights the pages have; None for all rights of this user.
    """

    listener: socket.socket
    access: Access
    certificate: KeyFolder | None = None
    role: Role | None = None


@contextlib.contextmanager
def listening(address: Address, certificate: Path | None, person: Path | None) -> Iterator[Endpoint]:
    """Listen at an address while the block lasts.

    Args:
        address: The address; others than those of this machine need a certificate and the keys of a person.
        certificate: Folder of keys with the role `site`, for TLS.
        person: Folder of the keys of a person; None for that of the environment or of the user.

    Raises:
        UsageError: The port is in use, the host is unknown, or keys are missing or do not name the host.
    """
    if address.is_local:
        with _open(address) as listener:
            hosts = tuple(dict.fromkeys((address.host, *_HERE)))
            yield Endpoint(listener, _access("http", hosts, listener))
        return
    if certificate is None:
        raise UsageError(
            f"{address} is outside this machine: others could read and start runs",
            help="add `--certificate DIR`, with a folder made by `seoro keys add NAME --role site --host "
            f"{address.host}`, and `--keys DIR` with the keys of a person",
        )
    keys = read_keys(certificate, frozenset({Role.SITE}))
    if address.host not in keys.identity.hosts:
        known = ", ".join(host for host in keys.identity.hosts if host not in _HERE) or "none"
        raise UsageError(
            f"the certificate in {certificate} is not for the host `{address.host}` (hosts: {known})",
            help=f"renew it: `seoro keys renew {keys.identity.name} --host {address.host}`",
        )
    identity = read_keys(person or chosen_folder() or default_folder(), frozenset(PEOPLE)).identity
    with _open(address) as listener:
        hosts = tuple(dict.fromkeys((address.host, *keys.identity.hosts)))
        yield Endpoint(listener, _access("https", hosts, listener), keys.folder, identity.role)


def _access(scheme: str, hosts: tuple[str, ...], listener: socket.socket) -> Access:
    return Access(scheme, tuple(map(_in_url, hosts)), listener.getsockname()[1])


def _in_url(host: str) -> str:
    return f"[{host}]" if ":" in host else host


@contextlib.contextmanager
def _open(address: Address) -> Iterator[socket.socket]:
    family = socket.AF_INET6 if ":" in address.host else socket.AF_INET
    try:
        listener = socket.create_server((address.host, address.port), family=family)
    except OSError as error:
        if error.errno == errno.EADDRINUSE:
            raise UsageError(
                f"port {address.port} is in use", help="choose another one, or 0 for a free one"
            ) from None
        reason = error.strerror or str(error)
        raise UsageError(f"cannot listen at {address}: {reason}", help="choose another address") from None
    with listener:
        yield listener

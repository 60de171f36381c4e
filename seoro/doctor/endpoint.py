"""Whether anything answers at an endpoint, below Zenoh: names, ports, sockets."""

from __future__ import annotations

import re
import socket
from pathlib import Path
from typing import Final

import anyio
from anyio.abc import SocketStream

from seoro.bridges.session import is_endpoint
from seoro.doctor.findings import Finding, failed, ok

TIMEOUT: Final = 3.0  # [s]
_PLACE: Final = re.compile(r"(tcp|tls|ws)/(?P<host>\[[^\]]+\]|[^:]+):(?P<port>\d+).*")
_FILE: Final = re.compile(r"unixsock-stream/(?P<path>[^?#]+).*")
_START: Final = (
    "start an executor there with `seoro serve`, or say with `--executor` or SEORO_EXECUTOR where one is"
)


async def look_at_endpoint(endpoint: str, start: str = _START) -> Finding:
    """Whether something listens at an endpoint.

    Args:
        endpoint: The endpoint.
        start: What to do if nothing does.
    """
    if not is_endpoint(endpoint):
        return failed("endpoint", f"'{endpoint}' is none", "endpoints look like tcp/127.0.0.1:7470")
    if match := _FILE.fullmatch(endpoint):
        return await _look_at_file(Path(match["path"]), start)
    if match := _PLACE.fullmatch(endpoint):
        return await _look_at_port(match["host"].strip("[]"), int(match["port"]), start)
    return ok("endpoint", f"{endpoint}: whether it answers is seen by Zenoh only")


async def _look_at_file(path: Path, start: str) -> Finding:
    try:
        with anyio.fail_after(TIMEOUT):
            stream = await anyio.connect_unix(path)
    except FileNotFoundError:
        return failed("endpoint", f"there is no socket {path}", start)
    except (OSError, TimeoutError) as error:
        return failed("endpoint", f"nothing listens at the socket {path}: {_reason(error)}", start)
    await stream.aclose()
    return ok("endpoint", f"something listens at {path}")


async def _look_at_port(host: str, port: int, start: str) -> Finding:
    if not 0 < port < 1 << 16:
        return failed("endpoint", f"there is no port {port}", "ports go from 1 to 65535")
    try:
        with anyio.fail_after(TIMEOUT):
            stream: SocketStream = await anyio.connect_tcp(host, port)
    except socket.gaierror:
        return failed(
            "endpoint", f"the name '{host}' belongs to no machine", "check how it is written, and the DNS"
        )
    except ConnectionRefusedError:
        return failed("endpoint", f"{host} is there, but nothing listens at its port {port}", start)
    except TimeoutError:
        text = f"{host} does not answer at port {port} within {TIMEOUT:g} s"
        return failed("endpoint", text, "check that it is on, and that no firewall is in the way")
    except OSError as error:
        if _is_refused(error):
            return failed("endpoint", f"{host} is there, but nothing listens at its port {port}", start)
        return failed("endpoint", f"{host} cannot be reached: {_reason(error)}", "check the network")
    await stream.aclose()
    return ok("endpoint", f"something listens at {host}, port {port}")


def _is_refused(error: OSError) -> bool:
    """Whether that is why: a host may have several addresses, and each its own reason."""
    cause = error.__cause__
    reasons = cause.exceptions if isinstance(cause, BaseExceptionGroup) else (cause,)
    return all(isinstance(each, ConnectionRefusedError) for each in reasons)


def _reason(error: BaseException) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error) or type(error).__name__

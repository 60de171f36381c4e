"""Checks of endpoints below Zenoh: host names, ports, sockets."""

from __future__ import annotations

import socket
from pathlib import Path
from typing import Final

import anyio
from anyio.abc import SocketStream

from seoro.bridges.session import is_endpoint
from seoro.bridges.session.endpoints import place_of
from seoro.doctor.findings import Finding, failed, ok

TIMEOUT: Final = 3.0  # [s]
_START: Final = "start an executor there with `seoro serve`, or name another with `--executor` or SEORO_EXECUTOR"


async def check_endpoint(endpoint: str, start: str = _START) -> Finding:
    """Check that a process listens at an endpoint.

    Args:
        endpoint: The endpoint.
        start: Suggestion if nothing listens there.
    """
    if not is_endpoint(endpoint):
        return failed("endpoint", f"invalid endpoint '{endpoint}'", "expected for example tcp/127.0.0.1:7470")
    match place_of(endpoint):
        case Path() as path:
            return await _check_socket(path, start)
        case (host, port):
            return await _check_port(host, port, start)
    return ok("endpoint", f"{endpoint}: only Zenoh can check this kind of endpoint")


async def _check_socket(path: Path, start: str) -> Finding:
    try:
        with anyio.fail_after(TIMEOUT):
            stream = await anyio.connect_unix(path)
    except FileNotFoundError:
        return failed("endpoint", f"socket not found: {path}", start)
    except (OSError, TimeoutError) as error:
        return failed("endpoint", f"nothing listens on socket {path}: {_reason(error)}", start)
    await stream.aclose()
    return ok("endpoint", f"a process listens on {path}")


async def _check_port(host: str, port: int, start: str) -> Finding:
    if not 0 < port < 1 << 16:
        return failed("endpoint", f"invalid port {port}", "expected 1 to 65535")
    try:
        with anyio.fail_after(TIMEOUT):
            stream: SocketStream = await anyio.connect_tcp(host, port)
    except socket.gaierror:
        return failed("endpoint", f"unknown host '{host}'", "check its spelling and the DNS")
    except TimeoutError:
        text = f"{host} does not answer on port {port} within {TIMEOUT:g} s"
        return failed("endpoint", text, "check that it is on, and that no firewall blocks the port")
    except OSError as error:
        if _is_refused(error):
            return failed("endpoint", f"{host} is up, but nothing listens on port {port}", start)
        return failed("endpoint", f"{host} is unreachable: {_reason(error)}", "check the network")
    await stream.aclose()
    return ok("endpoint", f"a process listens on {host}, port {port}")


def _is_refused(error: OSError) -> bool:
    """Return whether all addresses of a host refused the connection."""
    cause = error.__cause__ or error
    reasons = cause.exceptions if isinstance(cause, BaseExceptionGroup) else (cause,)
    return all(isinstance(each, ConnectionRefusedError) for each in reasons)


def _reason(error: BaseException) -> str:
    return (error.strerror if isinstance(error, OSError) else None) or str(error) or type(error).__name__

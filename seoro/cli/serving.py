"""Common parts of commands that serve on the network until a signal: executor, router, bridge."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager

import anyio

from seoro.cli.signals import termination_signals
from seoro.errors import UsageError, cause_of


def check_name(name: str, what: str) -> None:
    """Check the name of a node.

    Raises:
        UsageError: The name is invalid.
    """
    if re.fullmatch(r"[a-z0-9_-]+", name) is None:
        raise UsageError(f"invalid name '{name}' of {what}: use lower-case letters, digits, '_' and '-'")


def place_of(listen: str | None, connect: str | None) -> str:
    """Describe the endpoint of a node."""
    return f"listening on {listen}" if listen else f"connected to {connect}"


@contextmanager
def endpoint_errors(options: str = "`--listen` or `--connect`") -> Iterator[None]:
    """Convert errors of the endpoint into errors that name its options."""
    from seoro.bridges.session import SessionError  # noqa: PLC0415 - Zenoh, for commands that serve only

    try:
        yield
    except (SessionError, ExceptionGroup) as error:
        cause = cause_of(error)
        if not isinstance(cause, SessionError):
            raise
        raise UsageError(str(cause), help=f"choose another endpoint with {options}") from error


async def wait_for_signal() -> None:
    """Wait for the first signal that ends this command."""
    with anyio.open_signal_receiver(*termination_signals()) as signals:
        async for _ in signals:
            return

"""Event loop of commands that handle many messages."""

from __future__ import annotations

from asyncio import AbstractEventLoop
from collections.abc import Callable


def fast_loop() -> Callable[[], AbstractEventLoop] | None:
    """Return the factory of loops of uvloop, which handle messages sooner; None if it is not installed."""
    try:
        from uvloop import new_event_loop  # noqa: PLC0415 - seldom needed
    except ImportError:
        return None
    return new_event_loop

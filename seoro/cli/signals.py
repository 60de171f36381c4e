"""Signals that ask a command to end: Ctrl-C, those of `timeout` and service managers, a terminal that closes."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Iterator
from contextlib import contextmanager


def ending_signals() -> tuple[signal.Signals, ...]:
    """The signals that ask this command to end. A SIGHUP that is ignored, as under `nohup`, stays ignored."""
    is_ignored = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    return (signal.SIGINT, signal.SIGTERM, *(() if is_ignored else (signal.SIGHUP,)))


def status_of(number: signal.Signals) -> int:
    """The exit status of a command that a signal has ended, as shells have it."""
    return 128 + number


class Ended(Exception):
    """A signal has ended a command, and all that it had started has been ended in order.

    Args:
        number: The signal.
    """

    def __init__(self, number: signal.Signals) -> None:
        super().__init__(number.name)
        self.number = number


@contextmanager
def ending_by_signals() -> Iterator[None]:
    """In the block, the first signal cancels the present task. Later ones are ignored: clean-up is bounded.

    Raises:
        Ended: A signal has cancelled the task.
    """
    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    assert task is not None
    came: list[signal.Signals] = []

    def end(number: signal.Signals) -> None:
        if not came:
            task.cancel()
        came.append(number)

    numbers = ending_signals()
    for number in numbers:
        loop.add_signal_handler(number, end, number)
    try:
        yield
    except asyncio.CancelledError:
        if not came:
            raise
        raise Ended(came[0]) from None
    finally:
        for number in numbers:
            loop.remove_signal_handler(number)

"""Termination signals: Ctrl-C, SIGTERM of `timeout` and service managers, SIGHUP of a closed terminal."""

from __future__ import annotations

import asyncio
import signal
from collections.abc import Iterator
from contextlib import contextmanager


def termination_signals() -> tuple[signal.Signals, ...]:
    """Return the signals that end this command. SIGHUP stays ignored under `nohup`."""
    is_ignored = signal.getsignal(signal.SIGHUP) is signal.SIG_IGN
    return (signal.SIGINT, signal.SIGTERM, *(() if is_ignored else (signal.SIGHUP,)))


def status_of(number: signal.Signals) -> int:
    """Return the exit status of a command ended by a signal, as shells do."""
    return 128 + number


class Terminated(Exception):
    """A signal ended a command, after its clean-up.

    Args:
        number: The signal.
    """

    def __init__(self, number: signal.Signals) -> None:
        super().__init__(number.name)
        self.number = number


@contextmanager
def cancel_on_signals() -> Iterator[None]:
    """Cancel the current task at the first signal in the block. Later signals are ignored: clean-up is bounded.

    Raises:
        Terminated: A signal cancelled the task.
    """
    loop, task = asyncio.get_running_loop(), asyncio.current_task()
    assert task is not None
    received: list[signal.Signals] = []

    def end(number: signal.Signals) -> None:
        if not received:
            task.cancel()
        received.append(number)

    numbers = termination_signals()
    for number in numbers:
        loop.add_signal_handler(number, end, number)
    try:
        yield
    except asyncio.CancelledError:
        if not received:
            raise
        raise Terminated(received[0]) from None
    finally:
        for number in numbers:
            loop.remove_signal_handler(number)

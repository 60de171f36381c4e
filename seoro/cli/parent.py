"""`--die-with-parent`: the end of a command with the program that started it, however that program ends."""

from __future__ import annotations

import argparse
import os
import signal
import stat
import sys
from contextlib import suppress
from threading import Thread

from seoro.cli.arguments import add_option
from seoro.errors import UsageError


def add_parent_argument(parser: argparse.ArgumentParser, started: str) -> None:
    """Declare the option.

    Args:
        parser: The parser of the command.
        started: Names the processes of this command, in the plural.
    """
    add_option(parser, "--die-with-parent", f"end when stdin closes, for programs that start {started}")


def use_parent(options: argparse.Namespace) -> None:
    """Send SIGTERM to this process when stdin closes, if the option is given.

    Raises:
        UsageError: No program holds stdin open.
    """
    if options.die_with_parent:
        if not _is_held_open():
            raise UsageError(
                "expected a pipe as stdin", help="`--die-with-parent` is for programs that keep such a pipe open"
            )
        Thread(target=_terminate_at_the_end_of_stdin, daemon=True).start()


def _is_held_open() -> bool:
    """Return whether stdin is a pipe or a socket, as a program makes it."""
    if sys.stdin is None:
        return False
    mode = os.fstat(sys.stdin.fileno()).st_mode
    return stat.S_ISFIFO(mode) or stat.S_ISSOCK(mode)


def _terminate_at_the_end_of_stdin() -> None:
    with suppress(OSError):
        while os.read(sys.stdin.fileno(), 1024):
            continue
    os.kill(os.getpid(), signal.SIGTERM)

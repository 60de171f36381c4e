"""`--die-with-parent`: the end of a command with the program that started it, however that program ends."""

from __future__ import annotations

import argparse
import os
import signal
import sys
from contextlib import suppress
from threading import Thread

from seoro.cli.arguments import add_option


def add_parent_argument(parser: argparse.ArgumentParser, started: str) -> None:
    """Declare the option.

    Args:
        parser: The parser of the command.
        started: Names the processes of this command, in the plural.
    """
    add_option(parser, "--die-with-parent", f"end when stdin closes, for programs that start {started}")


def use_parent(options: argparse.Namespace) -> None:
    """Send SIGTERM to this process when stdin closes, if the option is given."""
    if options.die_with_parent:
        Thread(target=_terminate_at_the_end_of_stdin, daemon=True).start()


def _terminate_at_the_end_of_stdin() -> None:
    with suppress(OSError):
        while sys.stdin is not None and os.read(sys.stdin.fileno(), 1024):
            continue
        print("stdin has closed, which ends this command: --die-with-parent", file=sys.stderr, flush=True)
    os.kill(os.getpid(), signal.SIGTERM)

"""Confirmations by the user on the terminal."""

from __future__ import annotations

import sys

from seoro.errors import UsageError
from seoro.text.printable import one_line


def confirm(question: str, *, needed_by: str, otherwise: str) -> None:
    """Ask the user to confirm.

    Args:
        question: The question, without the answers.
        needed_by: Action that needs the confirmation, for the message without a terminal.
        otherwise: Message after another answer than yes.

    Raises:
        UsageError: Stdin is not a terminal, or the answer is not yes.
    """
    if not sys.stdin.isatty():
        raise UsageError(f"{needed_by} needs a confirmation", help="confirm with `--yes`")
    answer = input(f"{one_line(question)} [y/N] ")
    if answer.strip().lower() not in ("y", "yes"):
        raise UsageError(otherwise)

"""The option `--keys`."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from seoro.cli.arguments import Container, add_option
from seoro.security.keys import VARIABLE


def add_keys_argument(parser: Container) -> None:
    """Declare the option for the folder of keys."""
    add_option(
        parser,
        "--keys DIR",
        "folder of keys, for endpoints on other machines (default: SEORO_KEYS, else ~/.config/seoro/keys)",
        type=Path,
    )


@contextmanager
def using_keys(options: argparse.Namespace) -> Iterator[None]:
    """Use the keys of the options in this process and its child processes.

    The block restores the environment at its end, for programs that call `main`.
    """
    folder: Path | None = getattr(options, "keys", None)
    if folder is None:
        yield
        return
    before = os.environ.get(VARIABLE)
    os.environ[VARIABLE] = str(folder.absolute())
    try:
        yield
    finally:
        if before is None:
            os.environ.pop(VARIABLE, None)
        else:
            os.environ[VARIABLE] = before

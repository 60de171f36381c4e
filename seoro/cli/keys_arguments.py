"""The option by which commands are given keys."""

from __future__ import annotations

import argparse
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from seoro.cli.arguments import Container
from seoro.keys.folder import VARIABLE


def add_keys_argument(parser: Container) -> None:
    """Declare where the keys of this one are."""
    parser.add_argument(
        "--keys",
        type=Path,
        metavar="DIR",
        help="folder of keys, for endpoints outside this machine (default: that of SEORO_KEYS, else "
        "~/.config/seoro/keys)",
    )


@contextmanager
def using_keys(options: argparse.Namespace) -> Iterator[None]:
    """Use the keys that the options name, in this process and in those that it starts.

    The environment is restored at the end of the block, for programs that call `main`.
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

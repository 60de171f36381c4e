"""The option by which commands are given keys."""

from __future__ import annotations

import argparse
import os
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


def use_keys(options: argparse.Namespace) -> None:
    """Have this process, and those that it starts, use the keys that the options name."""
    folder: Path | None = getattr(options, "keys", None)
    if folder is not None:
        os.environ[VARIABLE] = str(folder.absolute())

"""Stdin and stdout of commands that speak a protocol of editors on them."""

from __future__ import annotations

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import BinaryIO


@contextmanager
def protocol_output() -> Iterator[BinaryIO]:
    """Provide stdout for a protocol; prints of libraries and actions go to stderr from now on."""
    with os.fdopen(os.dup(sys.stdout.fileno()), "wb") as out:
        os.dup2(sys.stderr.fileno(), sys.stdout.fileno())
        yield out

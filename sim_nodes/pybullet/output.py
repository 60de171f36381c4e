"""What Bullet prints, caught: it writes to the process's own stdout and stderr, past Python."""

from __future__ import annotations

import ctypes
import logging
import os
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager

log = logging.getLogger(__name__)


@contextmanager
def caught() -> Iterator[None]:
    """Log what C code in the block prints, which is dull unless something fails, for debugging."""
    libc = ctypes.CDLL(None)
    _flush(libc)
    kept = [(number, os.dup(number)) for number in (1, 2)]
    with tempfile.TemporaryFile() as file:
        try:
            for number, _ in kept:
                os.dup2(file.fileno(), number)
            yield
        finally:
            _flush(libc)
            for number, copy in kept:
                os.dup2(copy, number)
                os.close(copy)
            file.seek(0)
            for line in file.read().decode(errors="replace").splitlines():
                log.debug("%s", line)


def _flush(libc: ctypes.CDLL) -> None:
    """Have all that was printed so far written to where it belongs: C's buffers and Python's."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    libc.fflush(None)

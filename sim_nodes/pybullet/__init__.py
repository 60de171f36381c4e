"""The PyBullet engine; the only folder that imports pybullet.

Bullet writes directly to the process's stdout and stderr, on import, too.
"""

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
def captured_output() -> Iterator[None]:
    """Log the output of C code in the block at debug level."""
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
    """Flush the buffers of C and of Python."""
    for stream in (sys.stdout, sys.stderr):
        if stream is not None:
            stream.flush()
    libc.fflush(None)


with captured_output():
    import pybullet  # noqa: F401 - so that it is there when the modules of this folder import it

"""Room on the disk behind the end of a file, which nobody else gets."""

from __future__ import annotations

import ctypes
import errno
import os
from typing import Final

KEEP_SIZE: Final = 1  # of Linux's fallocate: the file does not become longer
UNSUPPORTED: Final = frozenset({errno.EOPNOTSUPP, errno.ENOSYS, errno.EINVAL, errno.ENODEV})


def reserve(descriptor: int, start: int, length: int) -> bool:
    """Reserve room for a part of a file that may lie behind its end; it keeps what is there.

    Args:
        descriptor: Of the file, which is open for writing.
        start: Where the part begins [bytes].
        length: Of the part [bytes].

    Returns:
        Whether the system and the file system can do that.

    Raises:
        OSError: There is no room.
    """
    fallocate = getattr(ctypes.CDLL(None, use_errno=True), "fallocate64", None)
    if fallocate is None:
        return False
    fallocate.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.c_int64, ctypes.c_int64)
    if fallocate(descriptor, KEEP_SIZE, start, length) == 0:
        return True
    error = ctypes.get_errno()
    if error in UNSUPPORTED:
        return False
    raise OSError(error, os.strerror(error))

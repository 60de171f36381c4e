"""Returns memory to the system: free memory, and memory that was filled with zeros."""

from __future__ import annotations

import ctypes
import mmap
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

MAPS = Path("/proc/self/maps")  # of Linux
FEWEST = 16  # pages that are returned at once
WORDS = mmap.PAGESIZE // 8  # of 64 bits in a page

Pages = NDArray[np.int64]


def return_free() -> None:
    """Return free memory of the C library, which keeps several MiB after large arrays; it takes about 1 ms."""
    trim: Any = getattr(ctypes.CDLL(None), "malloc_trim", None)  # of glibc
    if trim is not None:
        trim(ctypes.c_size_t(0))


@contextmanager
def zeros_returned() -> Iterator[None]:
    """Return the zeros in the memory that the block maps; no other thread may run meanwhile.

    A connection to Bullet clears about 20 MiB, of which most worlds use little. Returned pages read as zeros, too,
    and take memory again when they are written.
    """
    before = _pages()
    yield
    libc: Any = ctypes.CDLL(None)
    for run in _runs(np.setdiff1d(_pages(), before, assume_unique=True)):
        memory: Any = (ctypes.c_uint64 * (WORDS * len(run))).from_address(int(run[0]) * mmap.PAGESIZE)
        content = np.frombuffer(memory, np.uint64).reshape(-1, WORDS)
        for zeros in _runs(run[np.bitwise_or.reduce(content, axis=1) == 0]):
            if len(zeros) >= FEWEST:
                start, size = int(zeros[0]) * mmap.PAGESIZE, len(zeros) * mmap.PAGESIZE
                libc.madvise(ctypes.c_void_p(start), ctypes.c_size_t(size), mmap.MADV_DONTNEED)


def _pages() -> Pages:
    """Return the numbers of the pages of private memory without a file, sorted; none on other systems."""
    pages = [np.zeros(0, np.int64)]
    for line in MAPS.read_text().splitlines() if MAPS.exists() else ():
        addresses, permissions, _, _, inode, *name = line.split()
        if permissions == "rw-p" and inode == "0" and not name:
            first, end = (int(each, 16) // mmap.PAGESIZE for each in addresses.split("-"))
            pages.append(np.arange(first, end))
    return np.concatenate(pages)


def _runs(pages: Pages) -> list[Pages]:
    """Return the runs of consecutive pages."""
    return np.split(pages, np.flatnonzero(np.diff(pages) != 1) + 1) if len(pages) else []

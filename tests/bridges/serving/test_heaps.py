"""Heaps of processes that serve requests."""

from __future__ import annotations

import subprocess
import sys

import pytest

COUNT = """
import ctypes, threading
{limit}
started = threading.Barrier(9)

def use():
    kept = [bytes(2000) for _ in range(100)]  # larger than what Python allocates by itself
    started.wait()

threads = [threading.Thread(target=use) for _ in range(8)]
for thread in threads:
    thread.start()
started.wait()
libc = ctypes.CDLL(None)
libc.malloc_info(0, ctypes.c_void_p.in_dll(libc, "stdout"))
libc.fflush(None)
"""
LIMIT = "from seoro.bridges.serving.heaps import limit_heaps; limit_heaps()"


def heaps(limit: str) -> int:
    """Count the heaps of a process with nine threads."""
    line = [sys.executable, "-c", COUNT.format(limit=limit)]
    return subprocess.run(line, capture_output=True, check=True).stdout.count(b"<heap nr=")


@pytest.mark.skipif(sys.platform != "linux", reason="heaps of glibc")
def test_threads_share_a_heap() -> None:
    assert heaps("") > 2
    assert heaps(LIMIT) == 2

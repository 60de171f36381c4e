"""Reports of a fork server about its processes."""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import Final

REPORT: Final = struct.Struct("!Bii")  # kind, process id, and exit status if it has ended


class ProcessReport(IntEnum):
    """Kind of a report about a process."""

    STARTED = 1
    ENDED = 2

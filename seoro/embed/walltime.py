"""Limit of the wall time of a run: one hour, unless the caller or the scenario file gives another."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from typing import Final

DEFAULT: Final = 3600.0  # [s]


class Source(Enum):
    """Origins of the limit of a run."""

    CALLER = "caller"
    FILE = "file"
    DEFAULT = "default"


@dataclass(frozen=True)
class WallLimit:
    """The wall time that a run may take [s], and what raises it, for messages.

    Args:
        seconds: The limit.
        raised_by: The option or directive that gives it, or those that would.
        source: Who gives it.
    """

    seconds: float
    raised_by: str
    source: Source

    @property
    def reason(self) -> str:
        """The reason of a run that has reached the limit."""
        return f"no verdict within {self.seconds:g} s of wall time ({self.raised_by})"


def wall_limit(asked: float | None, option: str, of_file: float | None = None) -> WallLimit:
    """Choose the limit of a run: that of the caller, else of the file, else the default.

    Args:
        asked: Limit that the caller gives [s].
        option: The option of the caller, as messages write it.
        of_file: Limit that the scenario file gives [s].
    """
    if asked is not None:
        return WallLimit(asked, f"`{option}`", Source.CALLER)
    if of_file is not None:
        return WallLimit(of_file, "`# seoro: timeout` in the file", Source.FILE)
    raised_by = f"the default limit; `{option}` raises it, as does `# seoro: timeout 7200s`"
    return WallLimit(DEFAULT, raised_by, Source.DEFAULT)


OF_PROGRAMS: Final = wall_limit(None, "timeout=SECONDS")
"""The default limit of runs that Python programs start."""

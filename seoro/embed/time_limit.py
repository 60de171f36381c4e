"""Limit of the wall time of a run: that of the caller or the scenario file, by default one hour."""

from __future__ import annotations

from enum import Enum
from typing import Final

from seoro.lang.frozen import Value

DEFAULT: Final = 3600.0  # [s]


class Source(Enum):
    """Origin of a limit."""

    CALLER = "caller"
    FILE = "file"
    PROJECT = "project"
    DEFAULT = "default"


class WallLimit(Value):
    """Limit of the wall time of a run, with its origin for messages.

    Args:
        seconds: The limit [s].
        raised_by: Option or directive that sets it, or that can raise the default.
        source: Origin of the limit.
    """

    seconds: float
    raised_by: str
    source: Source

    @property
    def reason(self) -> str:
        """The reason of a run that has reached the limit."""
        return f"no verdict within {self.seconds:g} s of wall time ({self.raised_by})"


def wall_limit(
    given: float | None, option: str, of_file: float | None = None, of_project: float | None = None
) -> WallLimit:
    """Choose the limit of a run: that of the caller, else of the file, else of the project, else the default.

    Args:
        given: Limit that the caller gives [s].
        option: The option of the caller, as messages write it.
        of_file: Limit that the scenario file gives [s].
        of_project: Limit in the settings of the project [s].
    """
    if given is not None:
        return WallLimit(given, f"`{option}`", Source.CALLER)
    if of_file is not None:
        return WallLimit(of_file, "`# seoro: timeout` in the file", Source.FILE)
    if of_project is not None:
        return WallLimit(of_project, "`timeout` in the settings of the project", Source.PROJECT)
    raised_by = f"the default limit; `{option}` raises it, as does `# seoro: timeout 7200s`"
    return WallLimit(DEFAULT, raised_by, Source.DEFAULT)


PROGRAM_LIMIT: Final = wall_limit(None, "timeout=SECONDS")
"""The default limit of runs that Python programs start."""

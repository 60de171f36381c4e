"""Limit of the wall time of a run: one hour, unless somebody says otherwise."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Final

import anyio

from seoro.embed.runs import Run
from seoro.runtime.verdict import Verdict

DEFAULT: Final = 3600.0  # [s]


@dataclass(frozen=True)
class WallLimit:
    """The wall time that a run may take [s], and what raises it, for messages."""

    seconds: float
    raised_by: str

    @property
    def reason(self) -> str:
        """Why a run that has reached it ends."""
        return f"no verdict within {self.seconds:g} s of wall time ({self.raised_by})"


def wall_limit(asked: float | None, option: str = "--timeout", of_file: float | None = None) -> WallLimit:
    """The limit of a run.

    Args:
        asked: What the caller says [s]; None if it says nothing.
        option: The option that says it, for messages.
        of_file: What the scenario file says [s], which counts if the caller says nothing.
    """
    if asked is not None:
        return WallLimit(asked, f"`{option}`")
    if of_file is not None:
        return WallLimit(of_file, "`# seoro: timeout` in the file")
    return WallLimit(DEFAULT, f"the default limit; `{option} SECONDS` raises it, as does `# seoro: timeout 7200s`")


async def await_verdict(run: Run, limit: WallLimit) -> Verdict:
    """Wait for the verdict of a run, which is given up when it takes too long, and cleans up then."""
    with anyio.move_on_after(limit.seconds):
        return await run.result()
    run.give_up(limit.reason)
    return await run.result()

"""Line about a run that prints nothing for a while: its time, running actions, and distances to goals."""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable
from typing import Final

ON_TERMINAL: Final = 2.0  # [s] without output until the line is shown
IN_FILE: Final = 30.0  # [s] the same, and between two lines
REFRESH: Final = 1.0  # [s] between two changes of the line on a terminal
ERASE: Final = "\r\x1b[2K"  # of the line of the cursor (ECMA-48)


class QuietLine:
    """Line that is shown while a run is quiet. On a terminal, the next output replaces it.

    Args:
        write: Writes a text, without a line break.
        text: Returns the line at a time of the run's clock [s]; empty for none.
        is_terminal: Whether the output is a terminal.
        columns: Width of the terminal.
    """

    def __init__(
        self, write: Callable[[str], object], text: Callable[[float], str], is_terminal: bool, columns: int
    ) -> None:
        self._write = write
        self._text = text
        self._is_terminal = is_terminal
        self._columns = columns
        self._last = time.monotonic()  # of other output
        self._is_shown = False
        self._timer: asyncio.TimerHandle | None = None

    def start(self, clock: Callable[[], float]) -> None:
        """Watch a run with this clock [s]. Call it in an event loop."""
        self._plan(asyncio.get_running_loop(), clock)

    def stop(self) -> None:
        """Show no more lines."""
        if self._timer is not None:
            self._timer.cancel()
            self._timer = None

    def prefix(self) -> str:
        """Note that a line is printed; return the text in front of it, which erases a shown line."""
        self._last = time.monotonic()
        shown, self._is_shown = self._is_shown, False
        return ERASE if shown else ""

    def _plan(self, loop: asyncio.AbstractEventLoop, clock: Callable[[], float]) -> None:
        quiet = time.monotonic() - self._last
        limit = ON_TERMINAL if self._is_terminal else IN_FILE
        self._timer = loop.call_later(max(limit - quiet, REFRESH), self._show, loop, clock, limit)

    def _show(self, loop: asyncio.AbstractEventLoop, clock: Callable[[], float], limit: float) -> None:
        text = self._text(clock()) if time.monotonic() - self._last >= limit else ""
        if text and self._is_terminal:
            self._write(ERASE + text[: self._columns - 1])
            self._is_shown = True
        elif text:
            self._write(text + "\n")
            self._last = time.monotonic()
        self._plan(loop, clock)

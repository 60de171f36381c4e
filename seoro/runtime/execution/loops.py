"""Detection of instants that never settle: loops of behaviors that take no time."""

from __future__ import annotations

import logging
import time
from collections.abc import Callable
from typing import Final

from seoro.lang.source import Span
from seoro.runtime.values.environment import EvaluationError

STARTS: Final = 200_000  # of behaviors in one instant
# For slow machines. Runs that it ends differ between machines.
PROCESSOR_TIME: Final = 20.0  # [s] in one instant
NOTE_AFTER: Final = 1.0  # [s] of processor time in one instant before a warning
LOOK_EVERY: Final = 500  # starts

log = logging.getLogger(__name__)


class EndlessInstants:
    """Counts starts of behaviors in an instant.

    Args:
        give_up: Called with the reason and the span when an instant takes too long.
    """

    def __init__(self, give_up: Callable[[str, Span], object]) -> None:
        self._give_up = give_up
        self._instant = -1
        self._starts = 0
        self._began = 0.0  # [s] of processor time, at the first look in this instant
        self._has_noted = False

    def count(self, instant: int, span: Span) -> None:
        """Count a start of a behavior.

        Args:
            instant: Number of the instant.
            span: Of the behavior.

        Raises:
            EvaluationError: Too many behaviors started in this instant.
        """
        if self._instant != instant:
            self._instant, self._starts = instant, 0
        self._starts += 1
        if self._starts > STARTS:
            raise EvaluationError(
                f"instantaneous loop: more than {STARTS:,} behaviors started without time passing", span
            )
        if self._starts % LOOK_EVERY == 0:
            now = time.thread_time()
            if self._starts == LOOK_EVERY:
                self._began = now
            self._look(now - self._began, span)

    def _look(self, took: float, span: Span) -> None:
        if took > NOTE_AFTER and not self._has_noted:
            self._has_noted = True
            log.warning(
                "%s: %s behaviors have started without time passing; the run ends as an error at %s, or after "
                "%g s of processor time",
                span, f"{self._starts:,}", f"{STARTS:,}", PROCESSOR_TIME,
            )  # fmt: skip
        if took > PROCESSOR_TIME:
            self._give_up(
                f"limit reached: {self._starts:,} behaviors started without time passing, in more than "
                f"{PROCESSOR_TIME:g} s of processor time; a loop needs a `wait` that takes time",
                span,
            )

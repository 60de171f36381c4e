"""Margins: how far a run was from failing its checks.

A check with an ordered limit, such as `compare(x, "<", 0.9)` or `limit_speed(1mps)`, has a margin: the distance of
the value to the limit, as a share of the limit. It is negative beyond the limit. The margin of a run is its least.
"""

from __future__ import annotations

import math

from seoro.lang.source import Span
from seoro.runtime.trace.records import Trace


class Margins:
    """Margins of a run.

    Args:
        trace: Receiver of a record for each margin.

    Attributes:
        least: The least margin so far; None without one.
    """

    def __init__(self, trace: Trace) -> None:
        self._trace = trace
        self.least: float | None = None

    def record(self, check: str, distance: float, limit: float, span: Span, entity: str = "") -> None:
        """Record the margin of a check; distances that are not finite have none.

        Args:
            check: Name of the action or the modifier.
            distance: Distance of the value to the limit, negative beyond it.
            limit: The limit, in the same unit. The margin of a limit of zero is the distance itself.
            span: Its text.
            entity: Entity whose value it is; empty without one.
        """
        if not (math.isfinite(distance) and math.isfinite(limit)):
            return
        value = distance / abs(limit) if limit else float(distance)
        self.least = value if self.least is None else min(self.least, value)
        fields = {"entity": entity} if entity else {}
        self._trace.record(
            "margin", check=check, **fields, value=value, distance=distance, limit=limit, source=str(span)
        )

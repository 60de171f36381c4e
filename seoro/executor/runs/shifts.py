"""Shifts of workers of campaigns, which would hold their slots for hours.

Workers are asked to give way to waiting runs: their coordinators stop them after the present runs, and submit
others, which queue like all runs.
"""

from __future__ import annotations

import time
from collections.abc import Iterable
from typing import Final

from seoro.executor.runs.active_run import ActiveRun

SHIFT: Final = 10.0  # [s] that a worker keeps its slot at least, since its start costs time
PERIOD: Final = 1.0  # [s] between two checks while runs wait


def ask_to_give_way(active: Iterable[ActiveRun], waiting: Iterable[ActiveRun]) -> None:
    """Ask as many workers of campaigns to give way as runs wait, the longest active ones first.

    Args:
        active: Active runs.
        waiting: Waiting runs, which could start if a slot were free. Workers of one campaign do not replace each
            other.
    """
    now = time.time()
    workers = [live for live in active if live.submission.campaign is not None and not live.is_stopped]
    asked = sum(live.info.is_wanted for live in workers)
    candidates = sorted(
        (live for live in workers if not live.info.is_wanted and now - (live.info.started or now) >= SHIFT),
        key=lambda live: live.info.started or now,
    )
    for waits in list(waiting)[asked:]:
        other = next((live for live in candidates if _campaign(live) != _campaign(waits)), None)
        if other is None:
            return
        candidates.remove(other)
        other.set(is_wanted=True)


def _campaign(live: ActiveRun) -> tuple[str, str] | None:
    """Return the client and the identity of the campaign of a worker; None for other runs."""
    campaign = live.submission.campaign
    return None if campaign is None else (live.info.by, campaign.digest)

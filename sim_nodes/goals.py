"""What comes of goals: every goal that a robot has taken up ends once."""

from __future__ import annotations

from dataclasses import dataclass

from seoro.bridges.wire import Outcome

NOBODY = ""  # the id of a goal that nobody waits for any more; no client can give it


@dataclass(frozen=True)
class Ended:
    """How a goal ended, by the id that its client gave it; `interrupted` as in `Occurrence`."""

    id: str
    outcome: Outcome
    message: str = ""
    interrupted: bool = False

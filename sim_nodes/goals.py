"""Results of goals: each accepted goal ends once."""

from __future__ import annotations

from dataclasses import dataclass

from seoro.bridges.wire import Outcome

NO_CLIENT = ""  # id of a goal whose client is gone; clients cannot use it


@dataclass(frozen=True)
class GoalResult:
    """Result of a goal, with the id given by its client; `interrupted` as in `Occurrence`."""

    id: str
    outcome: Outcome
    message: str = ""
    interrupted: bool = False

"""What acts at the end of an instant, when nothing else is left to do in it: choices, then limits, then the rest.

Each time something has acted, the instant goes on, and settles again. Of those that lie within each other, the
inner act first: what they come to may spare the outer ones theirs.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

from seoro.runtime.rounds import Effects
from seoro.runtime.timetable import Limit


class Settling:
    """Waits for the end of the present instant."""

    def __init__(self) -> None:
        self._choices: list[Limit] = []
        self._limits: list[Limit] = []
        self._rest: list[Callable[[], None]] = []

    def choose(self, choice: Limit) -> None:
        """Add a choice that is to be made."""
        self._choices.append(choice)

    def reach(self, limit: Limit) -> None:
        """Add a limit that is reached."""
        self._limits.append(limit)

    def follow(self, act: Callable[[], None]) -> None:
        """Add what acts after these."""
        self._rest.append(act)

    def act(self, effects: Effects, *, with_limits: bool) -> bool:
        """Let the next of them act.

        Args:
            effects: Of the round; choices and limits end behaviors.
            with_limits: Whether limits may act.

        Returns:
            Whether there were any.
        """
        made, self._choices = _split(self._choices)
        if not made and with_limits:
            made, self._limits = _split(self._limits)
        for each in made:
            each.over = True
            effects.ends.append((each.scope.flow.path, each.act))
        if made:
            return True
        acts, self._rest = self._rest, []
        for act in acts:
            act()
        return bool(acts)


def _split(limits: Sequence[Limit]) -> tuple[list[Limit], list[Limit]]:
    """Of those that are not over: those that have no other within them, and the rest."""
    limits = [limit for limit in limits if not limit.over]
    if len(limits) < 2:
        return limits, []
    around = {scope for limit in limits for scope in limit.scope.around}
    return [each for each in limits if each.scope not in around], [each for each in limits if each.scope in around]

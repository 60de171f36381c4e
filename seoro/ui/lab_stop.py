"""Emergency stop of everything that a site reaches, which answers in time also if members do not."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, Final

import anyio

from seoro.errors import SeoroError
from seoro.lab.outcomes import Outcome

if TYPE_CHECKING:
    from anyio.abc import TaskGroup

    from seoro.client.lab import LabControl
    from seoro.ui.lab_watch import LabWatch
    from seoro.ui.own_runs import OwnRuns

ANSWER_WITHIN: Final = 2.0  # [s] from the request to the answer
REPEATING: Final = f"no answer within {ANSWER_WITHIN:g} s; the stop is being repeated"


class EmergencyStop:
    """Stops all robots and runs.

    Args:
        control: Control of the lab, with all executors of the site.
        watch: State of the lab; its members are expected to answer.
        tasks: Task group in which stops continue after the answer.
        own: Runs of the site itself.
    """

    def __init__(self, control: LabControl, watch: LabWatch, tasks: TaskGroup, own: OwnRuns) -> None:
        self._control = control
        self._watch = watch
        self._tasks = tasks
        self._own = own

    async def stop_all(self, reason: str) -> list[Mapping[str, Any]]:
        """Send the stop to all members; returns the outcome of each after `ANSWER_WITHIN` at the latest.

        Args:
            reason: Reason, shown to others.
        """
        found: dict[tuple[str, str], Outcome] = {}
        over, problem = anyio.Event(), ""

        def take(outcome: Outcome) -> None:
            key = (outcome.endpoint, outcome.display_name)
            if key not in found or found[key].error:
                found[key] = outcome

        async def stop() -> None:
            nonlocal problem
            try:
                await self._control.stop_all(reason, take)
            except SeoroError as error:
                problem = str(error)
            finally:
                over.set()
                self._watch.read_again()

        self._tasks.start_soon(stop)
        own = self._own.stop_all()
        with anyio.move_on_after(ANSWER_WITHIN):
            await over.wait()
        self._watch.read_again()
        outcomes = [
            *self._outcomes(found, is_over=over.is_set()),
            *({"name": name, "error": "", "done": "stopped"} for name in own),
        ]
        if problem or not outcomes:
            error = problem or "nothing was reached: no node, no executor and no run"
            outcomes.append({"name": "the lab", "error": error, "done": ""})
        return outcomes

    def _outcomes(self, found: Mapping[tuple[str, str], Outcome], *, is_over: bool) -> Iterator[Mapping[str, Any]]:
        """Yield the outcomes, and those of members that did not answer in time."""
        optional = self._watch.optional
        for outcome in found.values():
            if outcome.is_reached or outcome.endpoint not in optional:
                yield outcome_data(outcome)
        if is_over:
            return
        answered = {endpoint for endpoint, _ in found}
        for seen in self._watch.members:
            member = seen.member
            if (member.endpoint, member.display_name) not in found:
                yield {"name": member.display_name, "endpoint": member.endpoint, "error": REPEATING, "done": ""}
                answered.add(member.endpoint)
        for endpoint in self._watch.endpoints:
            if endpoint not in answered and endpoint not in optional:
                yield {"name": endpoint, "endpoint": endpoint, "error": REPEATING, "done": ""}


def outcome_data(outcome: Outcome) -> Mapping[str, Any]:
    """Return an outcome as JSON data; `elapsed` is in seconds."""
    return {
        "name": outcome.display_name,
        "endpoint": outcome.endpoint,
        "error": outcome.error,
        "done": outcome.done,
        "elapsed": outcome.elapsed if math.isfinite(outcome.elapsed) else None,
    }

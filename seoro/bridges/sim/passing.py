"""Granting time to a node, and having it simulate ahead.

Many grants end because something is due in the run, not in the simulation, and the run then asks the node for
nothing. Where that has been so for a while, a grant tells the node how much more is expected to be granted; what
it answers is kept, and the next grants are answered from that. When something is asked for before it is used up,
the node is sent back to the time of the run first. What is simulated, and what is told when, is the same to the
bit.
"""

from __future__ import annotations

from collections.abc import Mapping

from seoro.bridges import wire
from seoro.bridges.sim.messages import contact_arguments, departure_arguments
from seoro.bridges.sim.recording import RECORDED_GRANT, RecordingRequests
from seoro.bridges.sim.requests import REQUEST_TIMEOUT, NodeAddress, report_of
from seoro.bridges.sim.rules import TimeRules
from seoro.runtime.contracts import DEPARTURE, Happened

GRANT_TIMEOUT = 30.0  # [s]; a node that is this slow is given up
FAMILIAR = 4  # grants in a row, between which nothing was asked for, until the node simulates ahead
FURTHEST = 60.0  # [s] that it does so at most


class Foresight:
    """How far to have a node simulate ahead: twice as far each time that all of it was used."""

    def __init__(self) -> None:
        self.start_over()

    def start_over(self) -> None:
        """Something else was asked for."""
        self._quiet = 0  # grants since then
        self._grants = 1  # that the node was ahead

    def horizon(self, now: float, until: float) -> float | None:
        """Up to where grants are expected [s]; None if that cannot be said.

        Args:
            now: The time of the run [s].
            until: Where the present grant ends [s].
        """
        self._quiet += 1
        grant = until - now
        if self._quiet <= FAMILIAR or grant <= 0.0:
            return None
        self._grants *= 2
        ahead = min(self._grants * grant, FURTHEST)
        return until + ahead if ahead > grant else None

    def ended(self, ahead: float) -> None:
        """Something happened `ahead` [s] after the grant that had a horizon: it happens often, maybe."""
        if ahead <= 0.0:
            self.start_over()


class PassingRequests(RecordingRequests):
    """Time of a node.

    Args:
        address: How it is reached.
    """

    def __init__(self, address: NodeAddress) -> None:
        super().__init__(address)
        self._happened: Happened = _ignore
        self._foresight = Foresight()

    @property
    def time(self) -> float:
        """The time of the run [s]."""
        return self._time

    def set_clock(self, features: wire.SimulatorFeatures) -> None:
        """Take the time of the run from what the node says of itself.

        Raises:
            RuleBroken: It cannot be so.
        """
        self._rules = TimeRules(self.name, features, self._given.__contains__)
        self._steps_per_second = max(1, round(1.0 / features.step))
        self._rewinds = wire.REWIND.name in features.features
        self._time = features.time
        self._ahead: wire.Advanced | None = None  # what comes next; nothing happens before
        self._back: float | None = None  # where the run is, while the node may have gone ahead [s]

    async def advance(self, until: float) -> float:
        """Grant time; tells reporters what happened before the answer's time.

        Raises:
            RuleBroken: The answer breaks a rule.
            BackendLost: The node is gone.
        """
        advanced, may_be_ahead = self._ahead, True
        if advanced is None:
            horizon = self._horizon(until)
            advanced, may_be_ahead = await self._advance(until, horizon), horizon is not None
        reached = max(self._time, self._end_of(until))
        if may_be_ahead and reached < advanced.time:
            if self._back is not None:  # else something was asked for meanwhile, and it has come back
                self._ahead, self._back = advanced, reached
            self._time = reached
            return reached
        self._ahead = self._back = None
        self._time = advanced.time
        await self._tell(advanced)
        return advanced.time

    def _horizon(self, until: float) -> float | None:
        """How far the node is to simulate ahead; None for not at all."""
        may_go_ahead = self._rewinds and not self.is_recording
        return self._foresight.horizon(self._time, until) if may_go_ahead else None

    def _end_of(self, until: float) -> float:
        """The time at which a grant ends in which nothing happens [s]."""
        return wire.steps_until(until, self._steps_per_second) / self._steps_per_second

    async def _advance(self, until: float, horizon: float | None) -> wire.Advanced:
        if self.is_recording:  # which a grant may end before it is used up: the clock grants more
            until = min(until, self._time + RECORDED_GRANT)
        self._back = None if horizon is None else self._end_of(until)
        request = wire.Advance(until=until, horizon=horizon)
        advanced = await super().ask(wire.ADVANCE, request, GRANT_TIMEOUT)
        self._rules.check(self._time, self._end_of(until if horizon is None else horizon), advanced)
        if horizon is not None:
            self._foresight.ended(advanced.time - until)
        return advanced

    async def ask(
        self, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, timeout: float = REQUEST_TIMEOUT
    ) -> wire.A:
        """As `Requests.ask`; the node is at the time of the run when it is asked."""
        self._foresight.start_over()
        if self._back is not None:
            # Requests arrive in the order in which they are sent, also after a grant that is on its way; so who
            # asks next need not wait for this.
            rewind = wire.Rewind(time=self._back)
            self._ahead = self._back = None
            await super().ask(wire.REWIND, rewind)
        return await super().ask(verb, request, timeout)

    async def _tell(self, advanced: wire.Advanced) -> None:
        for contact in advanced.contacts:
            self._happened("contact", contact_arguments(contact))
        for departure in advanced.departures:
            self._happened(DEPARTURE, departure_arguments(departure))
        for feedback in advanced.feedback:
            self._happened("navigation_feedback", feedback.model_dump())
        for occurrence in advanced.occurrences:
            report = self._reporters.pop(occurrence.id, None)
            if report is not None:
                report(report_of(occurrence))
        await self.write_film(advanced.film, advanced.film_error)


def _ignore(name: str, arguments: Mapping[str, object]) -> None:
    """Before a run has started nobody listens."""

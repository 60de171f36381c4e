"""Holding robots: the sign of life of a run, and what it is told in answer."""

from __future__ import annotations

import math
import time
from collections.abc import Mapping
from contextlib import suppress

import anyio

from seoro.bridges import wire
from seoro.bridges.session import NoAnswer, NoServer, Refused, SessionError
from seoro.bridges.sim.messages import contact_arguments, departure_arguments
from seoro.bridges.sim.requests import NodeAddress, Requests, refusal_of, report_of
from seoro.bridges.wire.holding import HOLD_DEADLINE, HOLD_PATIENCE
from seoro.errors import BackendError, BackendLost, BackendStopped
from seoro.runtime.contracts import DEPARTURE, WARNING, Happened

ANSWER = 1.0  # [s] that the bridge may take beyond the wait that is asked for
PATIENCE = HOLD_PATIENCE
RETRY = 0.05  # [s] between two attempts while it is


class HoldingRequests(Requests):
    """Robots that are held.

    Args:
        address: How the bridge is reached.
        holder: Who holds them.
        number: Of the last thing that happened before.
    """

    def __init__(self, address: NodeAddress, holder: wire.Holder, number: int) -> None:
        super().__init__(address)
        self._holder = holder
        self._number = number
        self._happened: Happened = _ignore
        self._broken_since = math.inf
        self._stood_until = -math.inf  # end of the latest outage in which the node stopped its robots

    def loss_since(self, moment: float) -> str:
        """See `Connected`. The node repeats what happened during an outage, but a long one stops its robots."""
        if self._broken_since < math.inf:
            return f"{self.name} does not answer"
        if self._stood_until > moment:
            return f"{self.name} was not reached meanwhile, and its robots stood still"
        return ""

    async def hold(self) -> None:
        """Give signs of life, and tell what has happened; until it is cancelled, or the bridge is lost."""
        answered = time.monotonic()
        while True:
            request = wire.HoldRobots(holder=self._holder.holder, since=self._number, wait=wire.HOLD_WAIT)
            try:
                told = await self._ask_once(request)
            except Refused as refused:
                said: BackendError = refusal_of(refused)
                if not isinstance(said, BackendStopped):
                    said = BackendLost(f"{self.name} does not obey any more: {said}")
                self.report_loss(said)
                return
            except (NoServer, NoAnswer) as error:
                self._broken_since = min(self._broken_since, time.monotonic())
                if time.monotonic() - self._broken_since > PATIENCE:
                    self.report_loss(BackendLost(f"{self.name} has not answered for {PATIENCE:g} s: {error}"))
                    return
                await anyio.sleep(RETRY)
                continue
            except (SessionError, wire.WireError) as error:
                self.report_loss(BackendLost(f"{self.name} cannot be held: {error}"))
                return
            self._broken_since = math.inf
            before, answered = answered, time.monotonic()
            if answered - before > HOLD_DEADLINE + wire.HOLD_WAIT:
                self._stood_until = answered
            self._tell(told)

    async def catch_up(self) -> None:
        """Tell what has happened until now, as far as the bridge still says so."""
        with suppress(SessionError, wire.WireError):
            self._tell(await self._ask_once(wire.HoldRobots(holder=self._holder.holder, since=self._number)))

    async def _ask_once(self, request: wire.HoldRobots) -> wire.Happenings:
        verb, within = wire.HOLD_ROBOTS, request.wait + ANSWER
        answer = await self._address.query(verb, wire.encode(request), within, self._holder.holder)
        return verb.read_answer(answer)

    def _tell(self, told: wire.Happenings) -> None:
        news = [happening for happening in told.happenings if happening.number > self._number]
        self._number = max(told.number, self._number)
        for happening in news:
            if happening.contact is not None:
                self._happened("contact", contact_arguments(happening.contact))
            if happening.departure is not None:
                self._happened(DEPARTURE, departure_arguments(happening.departure))
            if happening.feedback is not None:
                self._happened("navigation_feedback", happening.feedback.model_dump())
            if happening.caution is not None:
                self._happened(WARNING, {"message": happening.caution.message})
            if happening.occurrence is not None:
                occurrence = happening.occurrence
                report = self._reporters.pop(occurrence.id, None)
                if report is not None:
                    report(report_of(occurrence))


def _ignore(name: str, arguments: Mapping[str, object]) -> None:
    """Before a run has started nobody listens."""

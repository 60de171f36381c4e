"""Grants of time to a node, simulation ahead of them, and videos of a run.

Many grants end at a deadline of the run, without a request to the node. After several such grants, the next one
also announces a horizon: the time of the expected further grants. The node simulates up to it, and its answer
serves these grants, too. Another request first rewinds the node to the time of the run. Feedback in such an
answer is reported at its times, since it hardly ever causes a request. The simulation and the times of its reports
are the same to the bit.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

from seoro.bridges import wire
from seoro.bridges.sim.requests import REQUEST_TIMEOUT, NodeAddress, Requests
from seoro.bridges.sim.rules import TimeRules
from seoro.bridges.sim.tracks import TrackRequests
from seoro.errors import BackendError

GRANT_TIMEOUT = 30.0  # [s]
QUIET_GRANTS = 4  # grants in a row without other requests, after which the node simulates ahead
MAX_HORIZON = 60.0  # [s] after the grant
RECORDED_GRANT = 0.2  # [s] longest grant while recording, since pictures take long
RECORDING_TIMEOUT = 30.0  # [s] of the machine's clock

Write = Callable[[bytes], object]


class Lookahead:
    """Horizon of grants, which doubles each time that it was used up."""

    def __init__(self) -> None:
        self.reset()

    def reset(self) -> None:
        """Start again, after another request."""
        self._quiet = 0  # number of grants since the last request
        self._ahead = 1  # horizon, in grants

    def horizon(self, now: float, until: float) -> float | None:
        """Return the time up to which grants are expected [s]; None if unknown.

        Args:
            now: The time of the run [s].
            until: End of the present grant [s].
        """
        self._quiet += 1
        grant = until - now
        if self._quiet <= QUIET_GRANTS or grant <= 0.0:
            return None
        self._ahead *= 2
        ahead = min(self._ahead * grant, MAX_HORIZON)
        return until + ahead if ahead > grant else None

    def ended(self, ahead: float) -> None:
        """Start again if an event ended the simulation `ahead` [s] after the grant, not beyond it."""
        if ahead <= 0.0:
            self.reset()


class RecordingRequests(Requests):
    """Recording by a node, one video at a time."""

    _write: Write | None = None
    _film_error = ""

    async def start_recording(self, request: wire.StartRecording, write: Write) -> None:
        """Start a recording.

        Args:
            request: Camera or robot to record, and the format.
            write: Called with each part of the video; its `OSError` ends the recording.

        Raises:
            BackendRefused: The node cannot record; the message has the reason.
        """
        await self.ask(wire.START_RECORDING, request, RECORDING_TIMEOUT)
        self._write, self._film_error = write, ""

    async def stop_recording(self) -> str:
        """Stop the recording, and write the rest; returns the reason if the video ended earlier."""
        if self._write is not None:
            await self._stop(self._write)
        return self._film_error

    @property
    def is_recording(self) -> bool:
        """Whether a recording is active."""
        return self._write is not None

    async def write_film(self, film: bytes, error: str) -> None:
        """Write a part of the video; the recording ends with an error, of writing or of the node."""
        if self._write is None:
            return
        failed = _written(self._write, film)
        self._film_error = failed or error
        if self._film_error:
            await self._stop(_nowhere if failed else self._write)

    async def _stop(self, write: Write) -> None:
        self._write = None
        try:
            recorded = await self.ask(wire.STOP_RECORDING, wire.Empty(), RECORDING_TIMEOUT)
        except BackendError as error:
            self._film_error = self._film_error or str(error)
            return
        failed = _written(write, recorded.film)
        self._film_error = self._film_error or recorded.error or failed


class AdvanceRequests(TrackRequests, RecordingRequests):
    """The clock of a node.

    Args:
        address: Address of the node.

    Attributes:
        time: The time of the run [s].
    """

    def __init__(self, address: NodeAddress) -> None:
        super().__init__(address)
        self._lookahead = Lookahead()

    def set_clock(self, features: wire.SimulatorFeatures) -> None:
        """Set the time of the run from the features of the node.

        Raises:
            ProtocolViolation: The step or the time is invalid.
        """
        self._rules = TimeRules(self.name, features, self._given.__contains__)
        self._steps_per_second = max(1, round(1.0 / features.step))
        self._rewinds = wire.REWIND.name in features.features
        self.time = features.time
        self._ahead: wire.Advanced | None = None  # answer ahead of the run, for the next grants
        self._feedback: deque[wire.NavigationFeedback] = deque()  # of that answer, not reported yet
        self._back: float | None = None  # time of the run while the node may be ahead [s]

    async def advance(self, until: float) -> float:
        """Grant time; reporters are called before the answer's time is reached.

        Raises:
            ProtocolViolation: The answer breaks a rule.
            BackendLost: The node is lost.
        """
        advanced, may_be_ahead = self._ahead, True
        if advanced is None:
            horizon = self._horizon(until)
            advanced, may_be_ahead = await self._advance(until, horizon), horizon is not None
            self.keep_samples(advanced)
            self._feedback = deque(advanced.feedback)
        reached = max(self.time, self._end_of(until))
        if self._feedback:
            reached = max(self.time, min(reached, self._feedback[0].time))
        if may_be_ahead and reached < advanced.time:
            if self._back is not None:  # else another request has rewound the node meanwhile
                self._ahead, self._back = advanced, reached
            self.time = reached
            self.report_samples(reached)
            self._report_feedback(reached)
            return reached
        self._ahead = self._back = None
        self.time = advanced.time
        self.report_samples(advanced.time)
        await self._report(advanced)
        return advanced.time

    def _report_feedback(self, until: float) -> None:
        while self._feedback and self._feedback[0].time <= until:
            self.report_event(self._feedback.popleft())

    def _horizon(self, until: float) -> float | None:
        """Return the time up to which the node simulates ahead; None for not at all."""
        may_go_ahead = self._rewinds and not self.is_recording
        return self._lookahead.horizon(self.time, until) if may_go_ahead else None

    def _end_of(self, until: float) -> float:
        """Return the end of a grant without events [s]."""
        return wire.steps_until(until, self._steps_per_second) / self._steps_per_second

    async def _advance(self, until: float, horizon: float | None) -> wire.Advanced:
        if self.is_recording:  # the clock grants the rest afterwards
            until = min(until, self.time + RECORDED_GRANT)
        self._back = None if horizon is None else self._end_of(until)
        request = wire.Advance(until=until, horizon=horizon, collects_feedback=horizon is not None)
        advanced = await super().ask(wire.ADVANCE, request, GRANT_TIMEOUT)
        self._rules.check(self.time, self._end_of(until if horizon is None else horizon), advanced)
        if horizon is not None and not advanced.feedback:
            self._lookahead.ended(advanced.time - until)
        return advanced

    async def ask(
        self, verb: wire.Verb[wire.Q, wire.A], request: wire.Q, timeout: float = REQUEST_TIMEOUT
    ) -> wire.A:
        """See `Requests.ask`. The node is rewound to the time of the run first."""
        self._lookahead.reset()
        if self._back is not None:
            # Requests arrive in order, also after a pending grant, so concurrent requests need not wait for this.
            rewind = wire.Rewind(time=self._back)
            self._ahead = self._back = None
            await super().ask(wire.REWIND, rewind)
        return await super().ask(verb, request, timeout)

    async def _report(self, advanced: wire.Advanced) -> None:
        for event in (*advanced.contacts, *advanced.departures, *self._feedback, *advanced.occurrences):
            self.report_event(event)
        self._feedback.clear()
        await self.write_film(advanced.film, advanced.film_error)


def _written(write: Write, film: bytes) -> str:
    """Write a part of a video; returns the reason of a failure, or nothing."""
    try:
        if film:
            write(film)
    except OSError as error:
        return error.strerror or str(error)
    return ""


def _nowhere(film: bytes) -> None:
    """Drop the rest of a video after a failed write."""

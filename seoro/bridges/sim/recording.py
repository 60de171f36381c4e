"""Films of a run: what a node records is written while the run goes on."""

from __future__ import annotations

from collections.abc import Callable

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.errors import BackendError

RECORDED_GRANT = 0.2  # [s]; pictures take long, and a grant has to be answered in time
RECORDING_TIMEOUT = 30.0  # [s] of the machine's clock

Write = Callable[[bytes], object]


class RecordingRequests(Requests):
    """Recording by a node; one film at a time."""

    _write: Write | None = None
    _film_error = ""

    async def start_recording(self, request: wire.StartRecording, write: Write) -> None:
        """Start to record.

        Args:
            request: What to record.
            write: Called with each part of the film; an `OSError` of it ends the recording.

        Raises:
            BackendRefused: The node cannot, and says why.
        """
        await self.ask(wire.START_RECORDING, request, RECORDING_TIMEOUT)
        self._write, self._film_error = write, ""

    async def stop_recording(self) -> str:
        """Stop, and write what is left; returns why the film ends before that, if it does."""
        if self._write is not None:
            await self._stop(self._write)
        return self._film_error

    @property
    def is_recording(self) -> bool:
        """Whether something is recorded."""
        return self._write is not None

    async def write_film(self, film: bytes, error: str) -> None:
        """Write a part of the film that is recorded; where that fails, or it is the last, recording ends."""
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


def _written(write: Write, film: bytes) -> str:
    """Write a part of a film; returns why that failed."""
    try:
        if film:
            write(film)
    except OSError as error:
        return error.strerror or str(error)
    return ""


def _nowhere(film: bytes) -> None:
    """What is left of a film that could not be written."""

"""Videos of a run, written while the node records."""

from __future__ import annotations

from collections.abc import Callable

from seoro.bridges import wire
from seoro.bridges.sim.requests import Requests
from seoro.errors import BackendError

RECORDED_GRANT = 0.2  # [s] longest grant while recording, since pictures take long
RECORDING_TIMEOUT = 30.0  # [s] of the machine's clock

Write = Callable[[bytes], object]


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

"""Films of runs in a simulator: MP4 files that are written while the run goes on, and play as far as they go.

async with prepare(scenario, options) as run:
    async with run.recording(Film(follow="turtlebot4"), Path("run.mp4")) as recording, run.running(limit):
        verdict = await run.result()
    if recording.error: ...
"""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import asdict, dataclass
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Final

import anyio

from seoro.bridges import wire
from seoro.errors import BackendRefused, InvalidUse
from seoro.runtime.verdict import Verdict, unproved

if TYPE_CHECKING:
    from seoro.bridges.sim.node import SimulatorNode

NAME: Final = "video.mp4"  # in a folder
DESCRIPTION: Final = "film of the run"


@dataclass(frozen=True)
class Film:
    """What is recorded: the whole world, unless it is of a camera, or follows something.

    Args:
        camera: Name of a camera of the simulator, whose pictures are as large as they are.
        follow: Name of a robot.
        width: Of pictures [pixels], an even number.
        height: The same.
        rate: Pictures per second of simulated time [Hz]: 1, 2, 5, 10, 25 or 50.
    """

    camera: str = ""
    follow: str = ""
    width: int = 640
    height: int = 360
    rate: int = 25


@dataclass
class Recording:
    """A film that is recorded.

    Args:
        error: Why it ends before the block in which it is recorded does; empty as long as it does not.
    """

    error: str = ""

    def checked(self, verdict: Verdict) -> Verdict:
        """The verdict of the run that is filmed: an error if the film does not show it to its end."""
        return unproved(verdict, f"the film ends early: {self.error}") if self.error else verdict


@asynccontextmanager
async def recording(node: SimulatorNode, film: Film, file: Path) -> AsyncIterator[Recording]:
    """Record a film while the block lasts.

    What ends it early is told by the recording, once the block has ended; the film can be played up to there.

    Args:
        node: The simulator.
        film: What to record.
        file: The MP4 file; its folder is made.

    Raises:
        InvalidUse: The file cannot be written, or there is nothing to record, or nothing to record with.
    """
    found = Recording()
    with _created(file) as opened:
        try:
            await node.start_recording(wire.StartRecording(**asdict(film)), opened.write)
        except BackendRefused as refused:
            _discard(file)
            raise InvalidUse(str(refused)) from refused
        try:
            yield found
        finally:
            with anyio.CancelScope(shield=True):
                found.error = await node.stop_recording()


def _created(file: Path) -> FileIO:
    try:
        file.parent.mkdir(parents=True, exist_ok=True)
        return file.open("wb", buffering=0)
    except OSError as error:
        raise InvalidUse(f"cannot write {file}: {error.strerror}") from error


def _discard(file: Path) -> None:
    """Leave no empty file where nothing is recorded; a device stays."""
    if file.is_file():
        file.unlink()

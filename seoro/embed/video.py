"""Videos of runs in a simulator: MP4 files, written during the run and playable at any time.

async with prepare(scenario, options) as run:
    async with run.recording(VideoOptions(follow="turtlebot4"), Path("run.mp4")) as recording, run.running(limit):
        verdict = await run.result()
    if recording.error: ...
"""

from __future__ import annotations

from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from dataclasses import asdict
from io import FileIO
from pathlib import Path
from typing import TYPE_CHECKING, Final

import anyio

from seoro.errors import BackendRefused, UsageError
from seoro.lang.frozen import Value
from seoro.runtime.execution.outputs import VIDEO
from seoro.runtime.verdict import Verdict, with_write_error

if TYPE_CHECKING:
    from seoro.bridges.sim.node import SimulatorNode

NAME: Final = VIDEO  # in a folder
DESCRIPTION: Final = "video of the run"


class VideoOptions(Value):
    """View and format of a video: of the whole world, a camera, or a followed robot.

    Args:
        camera: Name of a camera of the simulator, which determines the size.
        follow: Name of a robot to follow.
        width: Width [pixels], an even number.
        height: Height [pixels], an even number.
        rate: Frames per second of simulated time [Hz]: 1, 2, 5, 10, 25 or 50.
    """

    camera: str = ""
    follow: str = ""
    width: int = 640
    height: int = 360
    rate: int = 25


class Recording:
    """Video that is being recorded.

    Args:
        error: Reason of an early end; empty without one.
    """

    def __init__(self) -> None:
        self.error = ""

    def checked(self, verdict: Verdict) -> Verdict:
        """Return the verdict, or an error if the video ended early."""
        return with_write_error(verdict, f"the video ends early: {self.error}") if self.error else verdict


@asynccontextmanager
async def recording(node: SimulatorNode, view: VideoOptions, file: Path) -> AsyncIterator[Recording]:
    """Record a video while the block lasts.

    If the video ends early, the recording has the reason after the block, and the video is playable up to there.

    Args:
        node: The simulator.
        view: View and format.
        file: The MP4 file; its folder is created if missing.

    Raises:
        UsageError: The file cannot be written, or the simulator cannot record the view.
    """
    found = Recording()
    with _created(file) as opened:
        try:
            from seoro.bridges import wire  # noqa: PLC0415 - the messages of simulators

            await node.start_recording(wire.StartRecording(**asdict(view)), opened.write)
        except BackendRefused as refused:
            _discard(file)
            raise UsageError(str(refused)) from refused
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
        raise UsageError(f"cannot write {file}: {error.strerror}") from error


def _discard(file: Path) -> None:
    """Remove the empty file, unless it is a device."""
    if file.is_file():
        file.unlink()

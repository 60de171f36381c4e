"""Films: a fragmented MP4, whose parts come with the answers to grants of time, and its last when it stops."""

from __future__ import annotations

from seoro.bridges.wire.limits import BYTES
from seoro.bridges.wire.message import Empty, Message, Verb


class StartRecording(Message):
    """Record a film from now on, one at a time: of a camera, of a robot that is followed, or of the whole world.

    Recording goes on through resets and in another world of the same run, and ends when a world is loaded anew.
    """

    camera: str = ""
    follow: str = ""  # name of a robot or of what was spawned
    width: int = 640  # [pixels]; of a camera, its own
    height: int = 360
    rate: int = 25  # pictures per second of simulated time [Hz]


class Recorded(Message):
    """The last part of a film, and why it ends early, if it does."""

    film: bytes
    error: str = ""


START_RECORDING = Verb("start_recording", StartRecording, Empty)
STOP_RECORDING = Verb("stop_recording", Empty, Recorded, answers=BYTES)

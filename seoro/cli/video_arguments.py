"""Options for recording videos of runs."""

from __future__ import annotations

import argparse
import re
from pathlib import Path
from typing import TYPE_CHECKING

from seoro.cli.arguments import add_option, whole
from seoro.errors import UsageError
from seoro.runtime.execution.outputs import VIDEO

if TYPE_CHECKING:
    from seoro.embed.video import VideoOptions

OUTPUT_FOLDER = ""  # value of `--record-video` without a file
VIEWS = {"camera": "video_camera", "follow": "video_follow", "size": "video_size", "rate": "video_rate"}


def add_video_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_option(
        parser,
        "--record-video FILE|DIR",
        f"record a video of the simulator to this file, or to {VIDEO} in this folder (default: that of `-o`)",
        type=_file,
        nargs="?",
        const=OUTPUT_FOLDER,
    )
    add_view_arguments(parser)


def add_view_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options for the view of a video."""
    what = parser.add_mutually_exclusive_group()
    add_option(what, "--video-follow ROBOT", "record a robot from behind (default: the whole world)")
    add_option(what, "--video-camera NAME", "record the images of a camera of the simulator")
    add_option(parser, "--video-size WxH", "size in pixels, even numbers (default: 640x360)", type=_size)
    add_option(
        parser,
        "--video-rate",
        "frames per second of simulated time (default: 25)",
        type=whole,
        choices=(1, 2, 5, 10, 25, 50),
    )


def video_of(options: argparse.Namespace) -> tuple[VideoOptions, Path] | None:
    """Return the requested video and its file, or None.

    Raises:
        UsageError: The options contradict each other.
    """
    given = {name: value for name, key in VIEWS.items() if (value := getattr(options, key)) is not None}
    if options.record_video is None:
        if given:
            raise UsageError(f"`--video-{next(iter(given))}` needs a video", help="add `--record-video`")
        return None
    if options.sim is None and options.connect is None:
        raise UsageError("`--record-video` needs a simulator", help="add `--sim mujoco`")
    if "camera" in given and "size" in given:
        raise UsageError("the camera determines the size of its video", help="leave out `--video-size`")
    if "size" in given:
        given["width"], given["height"] = map(int, given.pop("size").split("x"))
    from seoro.embed.video import VideoOptions  # noqa: PLC0415 - for runs that are filmed

    return VideoOptions(**given), _place(options)


def _place(options: argparse.Namespace) -> Path:
    if options.record_video == OUTPUT_FOLDER and options.output_dir is None:
        raise UsageError("missing file for `--record-video`", help="name a file, or a folder with `-o`")
    if options.record_video == OUTPUT_FOLDER:
        return Path(options.output_dir) / VIDEO
    path = Path(options.record_video)
    return path if path.suffix == ".mp4" and not path.is_dir() else path / VIDEO


def _file(text: str) -> str:
    path = Path(text)
    if path.suffix not in ("", ".mp4") and not path.is_dir():
        raise argparse.ArgumentTypeError(
            f"expected an .mp4 file or a folder, found '{text}'; to record into the output folder, put the option "
            "after the scenario"
        )
    return text


def _size(text: str) -> str:
    if re.fullmatch(r"\d{2,4}x\d{2,4}", text) is None:
        raise argparse.ArgumentTypeError(f"expected WIDTHxHEIGHT in pixels, such as 1280x720, found {text!r}")
    return text

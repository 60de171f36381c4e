"""The options that say what film is recorded of a run, and where it goes."""

from __future__ import annotations

import argparse
import re
from pathlib import Path

from seoro.errors import InvalidUse
from seoro.film import NAME, Film

BESIDE = ""  # with the other results
VIEWS = {"camera": "video_camera", "follow": "video_follow", "size": "video_size", "rate": "video_rate"}


def add_film_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare them."""
    parser.add_argument(
        "--record-video",
        type=_file,
        nargs="?",
        const=BESIDE,
        metavar="FILE|DIR",
        help=f"record a film of the simulator there, as {NAME} in a folder; without a value, in that of `-o`",
    )
    add_view_arguments(parser)


def add_view_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare those that say what a film shows."""
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--video-follow", metavar="ROBOT", help="film a robot from behind (default: the whole world)"
    )
    what.add_argument("--video-camera", metavar="NAME", help="film what a camera of the simulator sees")
    parser.add_argument(
        "--video-size", type=_size, metavar="WxH", help="pixels of the film, even numbers (default: 640x360)"
    )
    parser.add_argument(
        "--video-rate",
        type=int,
        choices=(1, 2, 5, 10, 25, 50),
        help="pictures per second of simulated time (default: 25)",
    )


def film_of(options: argparse.Namespace) -> tuple[Film, Path] | None:
    """The film that the options ask for, and its file.

    Raises:
        InvalidUse: They do not go together.
    """
    given = {name: value for name, key in VIEWS.items() if (value := getattr(options, key)) is not None}
    if options.record_video is None:
        if given:
            raise InvalidUse(
                f"`--video-{next(iter(given))}` is about a film, and there is none", help="add `--record-video`"
            )
        return None
    if options.sim is None and options.connect is None:
        raise InvalidUse("a film is of a simulator, and there is none", help="add `--sim mujoco`")
    if "camera" in given and "size" in given:
        raise InvalidUse("a film of a camera is as large as its pictures", help="leave out `--video-size`")
    if "size" in given:
        given["width"], given["height"] = given.pop("size")
    return Film(**given), _place(options)


def film_texts(options: argparse.Namespace) -> list[str]:
    """The options that ask for a film beside the other results of a run, as they are written."""
    if options.record_video is None:
        return []
    given = {name: getattr(options, key) for name, key in VIEWS.items()}
    if given["size"] is not None:
        given["size"] = "{}x{}".format(*given["size"])
    return ["--record-video", *(f"--video-{name}={value}" for name, value in given.items() if value is not None)]


def _place(options: argparse.Namespace) -> Path:
    if options.record_video == BESIDE:
        if options.output_dir is None:
            raise InvalidUse(
                "`--record-video` has no place for the film", help="name a file, or a folder with `-o`"
            )
        return Path(options.output_dir) / NAME
    path = Path(options.record_video)
    return path if path.suffix == ".mp4" and not path.is_dir() else path / NAME


def _file(text: str) -> str:
    path = Path(text)
    if path.suffix not in ("", ".mp4") and not path.is_dir():
        raise argparse.ArgumentTypeError(
            f"films are .mp4 files, or go into a folder, unlike '{text}'; for one beside the other results, put "
            "the option after the scenario"
        )
    return text


def _size(text: str) -> tuple[int, int]:
    found = re.fullmatch(r"(\d{2,4})x(\d{2,4})", text)
    if found is None:
        raise argparse.ArgumentTypeError(f"expected WIDTHxHEIGHT in pixels, such as 1280x720, not {text!r}")
    return int(found[1]), int(found[2])

"""Options for recording videos."""

import argparse
from pathlib import Path

import pytest

from seoro import UsageError
from seoro.cli.video_arguments import add_video_arguments, video_of
from seoro.embed.video import VideoOptions


def options(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_video_arguments(parser)
    parsed = parser.parse_args(arguments)
    parsed.sim, parsed.connect, parsed.output_dir = "mujoco", None, None
    return parsed


def test_options_determine_the_view_and_the_file(tmp_path: Path) -> None:
    assert video_of(options()) is None
    assert video_of(options("--record-video=a.mp4")) == (VideoOptions(), Path("a.mp4"))
    folder = f"--record-video={tmp_path}"
    assert video_of(options(folder, "--video-follow=r")) == (VideoOptions(follow="r"), tmp_path / "video.mp4")
    wanted = VideoOptions(width=320, height=240, rate=5)
    assert video_of(options("--record-video=a.mp4", "--video-size=320x240", "--video-rate=5")) == (
        wanted,
        Path("a.mp4"),
    )
    assert video_of(options("--record-video=a.mp4", "--video-camera=c")) == (
        VideoOptions(camera="c"),
        Path("a.mp4"),
    )


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--video-rate=5",), "needs a video"),
        (("--record-video",), "missing file for `--record-video`"),
        (("--record-video=a.mp4", "--video-camera=c", "--video-size=64x48"), "the camera determines the size"),
    ],
)
def test_options_that_do_not_go_together_are_refused(arguments: tuple[str, ...], message: str) -> None:
    with pytest.raises(UsageError, match=message):
        video_of(options(*arguments))


@pytest.mark.parametrize("argument", ["--record-video=a.osc", "--video-size=640", "--video-rate=24"])
def test_values_that_make_no_sense_are_refused(argument: str) -> None:
    with pytest.raises(argparse.ArgumentError):
        options(argument)


def test_a_film_needs_a_simulator() -> None:
    parsed = options("--record-video=a.mp4")
    parsed.sim = None
    with pytest.raises(UsageError, match="needs a simulator"):
        video_of(parsed)

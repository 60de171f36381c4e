"""The options that say what film is recorded."""

import argparse
from pathlib import Path

import pytest

from seoro import InvalidUse
from seoro.cli.film_arguments import add_film_arguments, film_of, film_texts
from seoro.film import Film


def options(*arguments: str) -> argparse.Namespace:
    parser = argparse.ArgumentParser(exit_on_error=False)
    add_film_arguments(parser)
    parsed = parser.parse_args(arguments)
    parsed.sim, parsed.connect, parsed.output_dir = "mujoco", None, None
    return parsed


def test_options_say_what_is_recorded_and_where(tmp_path: Path) -> None:
    assert film_of(options()) is None
    assert film_of(options("--record-video=a.mp4")) == (Film(), Path("a.mp4"))
    folder = f"--record-video={tmp_path}"
    assert film_of(options(folder, "--video-follow=r")) == (Film(follow="r"), tmp_path / "video.mp4")
    wanted = Film(width=320, height=240, rate=5)
    assert film_of(options("--record-video=a.mp4", "--video-size=320x240", "--video-rate=5")) == (
        wanted,
        Path("a.mp4"),
    )
    assert film_of(options("--record-video=a.mp4", "--video-camera=c")) == (Film(camera="c"), Path("a.mp4"))


def test_sweeps_give_their_runs_the_options_of_films() -> None:
    assert film_texts(options("--record-video", "--video-size=64x48", "--video-follow=r")) == [
        "--record-video",
        "--video-follow=r",
        "--video-size=64x48",
    ]
    assert film_texts(options()) == []


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (("--video-rate=5",), "there is none"),
        (("--record-video",), "no place for the film"),
        (("--record-video=a.mp4", "--video-camera=c", "--video-size=64x48"), "as large as its pictures"),
    ],
)
def test_options_that_do_not_go_together_are_refused(arguments: tuple[str, ...], message: str) -> None:
    with pytest.raises(InvalidUse, match=message):
        film_of(options(*arguments))


@pytest.mark.parametrize("argument", ["--record-video=a.osc", "--video-size=640", "--video-rate=24"])
def test_values_that_make_no_sense_are_refused(argument: str) -> None:
    with pytest.raises(argparse.ArgumentError):
        options(argument)


def test_a_film_needs_a_simulator() -> None:
    parsed = options("--record-video=a.mp4")
    parsed.sim = None
    with pytest.raises(InvalidUse, match="a film is of a simulator"):
        film_of(parsed)

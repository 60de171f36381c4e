"""Films that are recorded of runs."""

import argparse
from pathlib import Path
from typing import Any

import pytest

from seoro import InvalidUse
from seoro.cli.film_arguments import add_film_arguments, film_of, film_texts
from seoro.cli.main import main
from seoro.film import Film
from tests.integration.conftest import SCENARIOS, StartSeoro, wait_until
from tests.sim_nodes.engines import needs_pictures

av: Any = pytest.importorskip("av", reason="PyAV is not installed")

SNAPSHOTS = str(SCENARIOS / "cameras" / "snapshots.osc")
SMALL = ("--sim", "mujoco", "--world", "empty", "--video-size", "64x48", "--video-rate", "10")


@pytest.fixture(autouse=True)
def _pictures() -> None:
    needs_pictures("mujoco")


def length(film: Path) -> float:
    """The time of the last picture [s]."""
    with av.open(str(film)) as container:
        return float([frame.time for frame in container.decode(video=0)][-1])


def test_a_film_is_as_long_as_the_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status = main(["exec", SNAPSHOTS, *SMALL, "--rate", "max", "-o", str(tmp_path), "--record-video"])
    assert status == 0
    assert length(tmp_path / "video.mp4") == 2.0
    assert str(tmp_path / "video.mp4") in capsys.readouterr().out


def test_a_film_that_cannot_be_written_makes_the_run_an_error(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    full = tmp_path / "full.mp4"
    full.symlink_to("/dev/full")
    assert main(["exec", SNAPSHOTS, *SMALL, "--rate", "max", "--record-video", str(full)]) == 3
    assert "the film ends early: No space left on device; the run itself: passed" in capsys.readouterr().err


def test_what_was_recorded_of_a_run_that_is_killed_plays(start_seoro: StartSeoro, tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    endless = tmp_path / "endless.osc"
    endless.write_text("import osc.cameras\nscenario endless:\n    eye: camera\n    do serial:\n")
    endless.write_text(
        endless.read_text() + "        eye.place(pose_3d(position_3d(z: 1m)))\n        wait elapsed(10000s)\n"
    )
    process = start_seoro("exec", str(endless), *SMALL, "--rate", "max", "--record-video", str(film))
    assert wait_until(lambda: film.exists() and film.stat().st_size > 3000, 30.0)
    process.kill()
    process.wait()
    assert length(film) > 0.5


def test_nothing_is_left_where_nothing_can_be_recorded(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    film = tmp_path / "film.mp4"
    assert main(["exec", SNAPSHOTS, *SMALL, "--record-video", str(film), "--video-follow", "ghost"]) == 2
    assert "there is no entity 'ghost'" in capsys.readouterr().err
    assert not film.exists()


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


@pytest.mark.slow
def test_a_sweep_records_a_film_of_each_run(tmp_path: Path) -> None:
    varied = tmp_path / "varied.osc"
    varied.write_text(
        "import osc.types\nscenario varied:\n    pause: time\n    keep(pause in [0.5s, 1s])\n"
        "    do serial:\n        wait elapsed(pause)\n"
    )
    folder = tmp_path / "sweep"
    arguments = ("sweep", str(varied), *SMALL, "--rate", "max", "-j", "1", "-o", str(folder), "--record-video")
    assert main(list(arguments)) == 0
    assert sorted(map(length, folder.rglob("video.mp4"))) == [0.5, 1.0]


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

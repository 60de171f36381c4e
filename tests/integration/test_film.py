"""Videos of runs."""

from pathlib import Path
from typing import Any

import pytest

from seoro.cli.main import main
from tests.integration.conftest import SCENARIOS, StartSeoro, wait_until
from tests.sim_nodes.engines import needs_pictures

av: Any = pytest.importorskip("av", reason="PyAV is not installed")

SNAPSHOTS = str(SCENARIOS / "cameras" / "snapshots.osc")
SMALL = ("--sim", "mujoco", "--world", "empty", "--video-size", "64x48", "--video-rate", "10")


@pytest.fixture(autouse=True)
def _pictures() -> None:
    needs_pictures("mujoco")


def length(film: Path) -> float:
    """Return the time of the last image [s]."""
    with av.open(str(film)) as container:
        return float([frame.time for frame in container.decode(video=0)][-1])


@pytest.mark.more
def test_a_video_is_as_long_as_the_run(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    status = main(["exec", SNAPSHOTS, *SMALL, "--rate", "max", "-o", str(tmp_path), "--record-video"])
    assert status == 0
    assert length(tmp_path / "video.mp4") == 2.0
    assert str(tmp_path / "video.mp4") in capsys.readouterr().out


@pytest.mark.more
def test_an_unwritable_video_ends_the_run_as_an_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    full = tmp_path / "full.mp4"
    full.symlink_to("/dev/full")
    assert main(["exec", SNAPSHOTS, *SMALL, "--rate", "max", "--record-video", str(full)]) == 3
    assert "the video ends early: No space left on device; the run itself: passed" in capsys.readouterr().err


def test_the_video_of_a_killed_run_is_playable(start_seoro: StartSeoro, tmp_path: Path) -> None:
    film = tmp_path / "film.mp4"
    endless = tmp_path / "endless.osc"
    endless.write_text("import osc.cameras\nscenario endless:\n    eye: camera\n    do serial:\n")
    endless.write_text(
        endless.read_text() + "        eye.place(pose_3d(position_3d(z: 1m)))\n        wait elapsed(10000s)\n"
    )
    process = start_seoro("exec", str(endless), *SMALL, "--rate", "max", "--record-video", str(film))
    wait_until(lambda: film.exists() and film.stat().st_size > 3000, 30.0)
    process.kill()
    process.wait()
    assert length(film) > 0.5


def test_a_failed_recording_leaves_no_file(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    film = tmp_path / "film.mp4"
    assert main(["exec", SNAPSHOTS, *SMALL, "--record-video", str(film), "--video-follow", "ghost"]) == 2
    assert "unknown entity 'ghost'" in capsys.readouterr().err
    assert not film.exists()


@pytest.mark.more
def test_a_campaign_keeps_a_video_of_each_run(tmp_path: Path) -> None:
    varied = tmp_path / "varied.osc"
    varied.write_text(
        "import osc.types\nscenario varied:\n    pause: time\n    keep(pause in [0.5s, 1s])\n"
        "    do serial:\n        wait elapsed(pause)\n"
    )
    folder = tmp_path / "out"
    arguments = ("campaign", "run", str(varied), *SMALL, "--rate", "max", "-j", "1", "-o", str(folder))
    assert main([*arguments, "--record-video", "--keep", "all"]) == 0
    assert sorted(map(length, folder.rglob("video.mp4"))) == [0.5, 1.0]

"""Live pictures of the cameras of runs, from real simulators."""

from __future__ import annotations

import asyncio
import io
import json
import socket
import stat
import sys
from collections.abc import AsyncIterator
from contextlib import asynccontextmanager
from pathlib import Path
from typing import Any

import anyio
import pytest
from PIL import Image

from seoro.embed.picture_server import NAME
from seoro.ui.pictures import NoPictures, connect_pictures
from tests.sim_nodes.engines import needs_pictures

pytestmark = pytest.mark.anyio

DEADLINE = 120.0  # [s]
SCENARIO = """import osc.driving
import osc.helpers

scenario turning:
    timeout(600s)
    robot: differential_drive_robot
    event tick
    on every(20ms):
        emit tick
    do serial:
        robot.drive(linear: 0.1mps, angular: 0.5radps, duration: 3s)
        wait elapsed({pause}s)
        robot.drive(linear: 0.1mps, angular: -0.5radps, duration: 3s)
"""


def written(folder: Path, pause: float = 1.0) -> Path:
    path = folder / "turning.osc"
    path.write_text(SCENARIO.format(pause=pause))
    return path


@asynccontextmanager
async def running(file: Path, output: Path, *options: str) -> AsyncIterator[asyncio.subprocess.Process]:
    command = ["-m", "seoro.cli.main", "exec", str(file), "--sim", "mujoco", "--seed", "1", "-o", str(output)]
    process = await asyncio.create_subprocess_exec(
        sys.executable, *command, *options, stdout=asyncio.subprocess.DEVNULL, stderr=asyncio.subprocess.PIPE
    )
    try:
        yield process
    finally:
        if process.returncode is None:
            process.terminate()
        await process.communicate()


async def served(folder: Path) -> None:
    """Wait for the socket of a run."""
    with anyio.fail_after(DEADLINE):
        while not (folder / NAME).exists():
            await anyio.sleep(0.02)


def records(folder: Path) -> list[dict[str, Any]]:
    """Return the trace without times of the machine."""
    found = [json.loads(line) for line in (folder / "trace.jsonl").read_text().splitlines()]
    for record in found:
        record.pop("wall", None)
        record.pop("wall_duration", None)
    return found


async def test_viewers_get_pictures_and_change_nothing(tmp_path: Path) -> None:
    file = written(tmp_path)
    needs_pictures("mujoco")
    plain, viewed = tmp_path / "plain", tmp_path / "viewed"
    async with running(file, plain, "--rate", "max") as process:
        assert await process.wait() == 0
    times: list[float] = []
    async with running(file, viewed, "--rate", "2") as process:
        await served(viewed)
        assert stat.S_IMODE((viewed / NAME).lstat().st_mode) == 0o600
        async with connect_pictures([viewed]) as pictures:
            (camera,) = await pictures.cameras()
            assert camera == "turtlebot4/front"
            with pytest.raises(NoPictures, match="camera"):
                await pictures.take("nobody")
            try:
                while True:
                    found = await pictures.take(camera)
                    assert Image.open(io.BytesIO(found.png)).format == "PNG"
                    times.append(found.time)
            except NoPictures as error:
                assert "ended" in str(error)
        assert await process.wait() == 0
    assert len(times) >= 3
    assert times == sorted(times)
    assert times[-1] <= 8.0
    ours, theirs = records(plain), records(viewed)
    assert [each for each in ours if each["kind"] != "run.start"] == [
        each for each in theirs if each["kind"] != "run.start"
    ]
    assert not (viewed / NAME).exists()


async def test_runs_without_pictures_say_why(tmp_path: Path) -> None:
    with pytest.raises(NoPictures, match="no simulator"):
        async with connect_pictures([tmp_path]):
            pass
    with socket.socket(socket.AF_UNIX) as left:
        left.bind(str(tmp_path / NAME))
    with pytest.raises(NoPictures, match="has ended"):
        async with connect_pictures([tmp_path]):
            pass
    (tmp_path / "link").mkdir()
    (tmp_path / "link" / NAME).symlink_to(tmp_path / NAME)
    with pytest.raises(NoPictures, match="no simulator"):
        async with connect_pictures([tmp_path / "link"]):
            pass

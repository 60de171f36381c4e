"""Live pictures of the cameras of runs, from real simulators."""

from __future__ import annotations

import asyncio
import io
import json
import re
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
from websockets.exceptions import ConnectionClosed

from seoro.client import Client
from seoro.embed.options import Simulator
from seoro.embed.picture_server import NAME
from seoro.files.executor_links import LINKS
from seoro.ui.pictures import NoPictures, connect_pictures
from seoro.ui.server import SiteOptions
from tests.executors import NAME as NAME_OF_LAB
from tests.executors import RunningExecutor, executor
from tests.sim_nodes.engines import needs_pictures
from tests.ui.browsing import Browser, opened
from tests.ui.conftest import serving

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
    command = ["-m", "seoro", "exec", str(file), "--sim", "mujoco", "--seed", "1", "-o", str(output)]
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


@pytest.mark.more
async def test_viewers_get_pictures_and_change_nothing(tmp_path: Path) -> None:
    file = written(tmp_path, pause=6.0)
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
    assert len(times) >= 2
    assert times == sorted(times)
    assert times[-1] <= 13.0
    ours, theirs = records(plain), records(viewed)
    assert (ours[0].get("rate"), theirs[0]["rate"]) == (None, 2.0)
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


async def test_a_page_shows_pictures_of_a_run_in_a_folder(browser: Browser, folder: Path, tmp_path: Path) -> None:
    needs_pictures("mujoco")
    output = folder / "pictured"
    async with running(written(tmp_path, pause=60.0), output, "--rate", "1"):
        run = await asyncio.to_thread(
            browser.run, lambda found: found["folder"] == str(output) and found["status"] == "running"
        )
        assert await asyncio.to_thread(received, browser, run["id"]) == "turtlebot4/front"


@pytest.mark.more
async def test_a_page_shows_pictures_of_runs_of_executors_on_this_machine(
    lab: RunningExecutor, browser: Browser, tmp_path: Path
) -> None:
    needs_pictures("mujoco")
    with (
        serving(SiteOptions((tmp_path,), lab.folder / "ui", lab.endpoint)) as served,
        opened(served.access) as own,
    ):
        async with Client(lab.endpoint) as client:
            simulator = Simulator("mujoco", rate=1.0)
            run = await client.submit(NAME_OF_LAB, written(tmp_path, pause=60.0), simulator=simulator)
            await asyncio.to_thread(
                own.run, lambda found: found["id"] == f"x{run.id}" and found["status"] == "running"
            )
            try:
                assert await asyncio.to_thread(received, own, f"x{run.id}") == "turtlebot4/front"
                found = await asyncio.to_thread(browser.get, f"/api/run/x{run.id}/cameras")
                assert found["cameras"] == []
                assert "runs on this machine only" in found["problem"]
            finally:
                await run.stop("the test is over")


@pytest.mark.more
async def test_a_page_shows_pictures_of_executors_in_other_folders(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    needs_pictures("mujoco")
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    left = tmp_path / "state" / "seoro" / LINKS / "left"
    left.parent.mkdir(parents=True)
    left.symlink_to(tmp_path / "nowhere")
    (tmp_path / "elsewhere").mkdir()
    with (
        executor(tmp_path / "elsewhere") as running_executor,
        serving(
            SiteOptions((tmp_path,), tmp_path / "state" / "seoro" / "ui", running_executor.endpoint)
        ) as served,
        opened(served.access) as own,
    ):
        async with Client(running_executor.endpoint) as client:
            run = await client.submit(
                NAME_OF_LAB, written(tmp_path, pause=60.0), simulator=Simulator("mujoco", rate=1.0)
            )
            await asyncio.to_thread(
                own.run, lambda found: found["id"] == f"x{run.id}" and found["status"] == "running"
            )
            try:
                assert await asyncio.to_thread(received, own, f"x{run.id}") == "turtlebot4/front"
            finally:
                await run.stop("the test is over")
        assert [link.resolve() for link in left.parent.iterdir()] == [running_executor.folder / "state"]
    assert list(left.parent.iterdir()) == []


def received(browser: Browser, run: str) -> str:
    """Receive a picture of the first camera of a run; returns the name of the camera."""
    while not (found := browser.get(f"/api/run/{run}/cameras"))["cameras"]:
        assert re.search("simulator|ended|this machine", found["problem"])  # it begins
    name: str = found["cameras"][0]["name"]
    with browser.socket(f"/api/run/{run}/camera?name={name}") as socket:
        data = socket.recv(DEADLINE)
    assert isinstance(data, bytes)
    assert Image.open(io.BytesIO(data)).format == "PNG"
    return name


def test_runs_that_have_ended_have_no_pictures(browser: Browser, hello: Path) -> None:
    run = browser.run(lambda found: found["folder"] == str(hello) and found["status"] == "passed")
    found = browser.get(f"/api/run/{run['id']}/cameras")
    assert found == {"cameras": [], "problem": "the run has ended"}
    with browser.socket(f"/api/run/{run['id']}/camera?name=front") as socket, pytest.raises(ConnectionClosed):
        assert json.loads(socket.recv(DEADLINE))["error"] == "the run has ended"
        socket.recv(DEADLINE)

"""Files that a scenario names by absolute paths are found on an executor, where these paths do not exist."""

import math
import shutil
from pathlib import Path

import anyio
import pytest

import seoro
from seoro.bridges.models import OWN_MODELS
from tests.executors import LONG, NAME, executor

PARTS = 'import "more.osc"\nimport osc.helpers\nscenario part:\n    do serial:\n        log("there")\n'
MAIN = """import "{folder}/common/parts.osc"
import osc.gazebo
scenario main:
    timeout(20s)
    box: sim_object
    do serial:
        part()
        box.spawn(pose_3d(position_3d(x: 1m, y: 1m, z: 1m)), "file://{folder}/models/box.sdf")
"""


@pytest.mark.engine("mujoco")
async def test_they_are_found_by_the_names_that_the_user_gives_them(tmp_path: Path) -> None:
    folder = tmp_path / "here"
    for name, text in (("common/parts", PARTS), ("common/more", "struct more\n"), ("tests/main", MAIN)):
        path = folder / f"{name}.osc"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(text.format(folder=folder) if name == "tests/main" else text)
    (folder / "models").mkdir()
    shutil.copy(OWN_MODELS / "example_simulation/models/box.sdf", folder / "models")
    long = tmp_path / "long.osc"
    long.write_text(LONG)
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            before = await client.submit(NAME, long)
            simulator = seoro.Simulator(name="mujoco", world="empty", rate=math.inf)
            run = await client.submit(NAME, folder / "tests/main.osc", simulator=simulator)
            shutil.rmtree(folder)  # while it waits
            await before.stop()
            with anyio.fail_after(60.0):
                records = [record async for record in run.records()]
                verdict = await run.result()
    assert verdict.passed, verdict
    [log] = [record for record in records if record["kind"] == "log"]
    assert log["source"] == f"{folder}/common/parts.osc:5:9"
    assert verdict.file == f"{folder}/tests/main.osc"

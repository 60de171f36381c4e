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

COMPUTED = """import osc.gazebo
scenario main:
    box: sim_object
    model: string
    do serial:
        box.spawn(pose_3d(position_3d(x: 1m, y: 1m, z: 1m)), model)
"""


@pytest.mark.more
@pytest.mark.engine("mujoco")
async def test_files_with_absolute_paths_are_found_by_their_paths(tmp_path: Path) -> None:
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


@pytest.mark.more
@pytest.mark.engine("mujoco")
async def test_files_that_were_not_sent_are_not_readable(tmp_path: Path) -> None:
    """Clients do not check computed paths."""
    secret = tmp_path / "secret.sdf"
    shutil.copy(OWN_MODELS / "example_simulation/models/box.sdf", secret)
    file = tmp_path / "main.osc"
    file.write_text(COMPUTED)
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            simulator = seoro.Simulator(name="mujoco", world="empty", rate=math.inf)
            overrides = {"model": f'"file://{secret}"'}
            run = await client.submit(NAME, file, simulator=simulator, overrides=overrides)
            with anyio.fail_after(60.0):
                verdict = await run.result()
    assert verdict.status is seoro.RunStatus.FAILED
    assert f"does not allow scenarios to read {secret}, which was not sent" in verdict.reason

"""Write the files and messages of this version to `tests/data/formats/VERSION`.

    python -m tests.distribution.formats.make

Run it once, for each release; files of earlier versions never change.
"""

from __future__ import annotations

import asyncio
import json
import platform
import shutil
from contextlib import chdir
from pathlib import Path

import seoro
from seoro.cli.main import main
from tests.distribution.formats import exchanges
from tests.executors import HELLO, NAME, executor

FORMATS = Path(__file__).parents[2] / "data" / "formats"
WORK = Path("/tmp/elsewhere")  # the same path on each machine, since files and messages contain it
LARGEST = 10_000  # [bytes] of a reply that is kept
DELIVER = """import osc.helpers
import osc.types

actor porter:
    event released(by: string)

scenario deliver:
    robot: porter
    load: mass with:
        keep(it in [1kg..20kg])
    var trips: int = 0
    event arrived(count: int)
    cover(load, unit: kg, event: arrived)
    do parallel:
        serial:
            serial:
                wait elapsed(500ms)
                increment(trips)
                emit arrived(trips)
            with:
                repeat(2)
            wait @robot.released
            log("released")
        serial:
            wait @arrived
            compare(load, "<", 15kg)
"""
LOAD = """import osc.helpers
import osc.types

scenario load:
    load: mass with:
        keep(it in [1kg..20kg])
    cover(load, unit: kg, event: start)
    do serial:
        wait elapsed(2s)
        compare(load, "<", 15kg)
"""
DRIVE = """import osc.helpers
import osc.nav2
import osc.snapshots

scenario drive:
    robot: differential_drive_robot
    do serial:
        robot.init_nav2(pose_3d())
        robot.nav_to_pose(pose_3d(position_3d(x: 0.3m)))
        save_snapshot('there')
"""


async def released(scenario: seoro.Scenario) -> list[str]:
    """Run a scenario with an application that emits an event; returns its trace as lines."""
    async with seoro.start(
        scenario,
        seed=1,
        clock="virtual",
        overrides={"load": 5.0},
        external=["robot.released"],
        keep_trace=True,
    ) as run:
        async with run.subscribe("arrived") as arrivals:
            await anext(arrivals)
            await anext(arrivals)
            await run.emit("robot.released", by="Ada")
        verdict = await run.result()
        assert verdict.passed, verdict
        return [json.dumps(record) async for record in run.trace()]


def succeed(*command: str, status: int = 0) -> None:
    """Run a command of seoro in this process."""
    found = main(list(command))
    assert found == status, f"{command}: {found}"


async def submit(endpoint: str) -> None:
    """Run a scenario on an executor, and download its files."""
    async with seoro.Client(endpoint) as client:
        run = await client.submit(NAME, "hello.osc", seed=7)
        assert [record["kind"] async for record in run.records()]
        assert (await run.result()).passed
        await run.fetch("fetched")
        assert await client.runs(NAME)


def record_node(folder: Path) -> None:
    """Record exchanges with a simulator: the first of each verb."""
    with exchanges.recording() as found:
        options = ["--sim", "mujoco", "--rate", "max", "--seed", "7", "-o", "out"]
        succeed("exec", "drive.osc", *options)
    first = {each.verb: each for each in reversed(found) if len(each.reply) <= LARGEST}
    exchanges.write(folder / "node.jsonl", list(first.values()))


def record_executor(folder: Path) -> None:
    """Record exchanges with an executor: all of a run."""
    with executor(Path.cwd()) as running, exchanges.recording() as found:
        asyncio.run(submit(running.endpoint))
    exchanges.write(folder / "executor.jsonl", found)


def make(folder: Path) -> None:
    """Write all into a folder, from the working folder."""
    for name, text in {"deliver": DELIVER, "load": LOAD, "drive": DRIVE, "hello": HELLO}.items():
        Path(f"{name}.osc").write_text(text)
    trace = asyncio.run(released(seoro.load("deliver.osc")))
    (folder / "trace.jsonl").write_text("".join(f"{line}\n" for line in trace))
    succeed("exec", "load.osc", "--seed", "5", "--clock", "virtual", "-o", str(folder / "run"))
    options = ["--strategy", "latin", "--runs", "6", "--seed", "1", "--clock", "virtual"]
    succeed("campaign", "run", "load.osc", *options, "-o", str(folder / "campaign"), status=1)
    for pattern in ("report.html", "runs.csv", "runs.parquet", "lock"):  # written again by any version
        for file in folder.rglob(pattern):
            file.unlink()
    for name in ("deliver.osc", "load.osc"):
        shutil.copy(name, folder)
    record_node(folder)
    record_executor(folder)


def rename_machine(folder: Path) -> None:
    """Replace the name of this machine in JUnit XML and in the rows of a campaign."""
    for file in folder.rglob("test.xml"):
        file.write_text(file.read_text().replace(f'hostname="{platform.node()}"', 'hostname="machine"'))
    for file in list((folder / "campaign" / "runs").iterdir()):
        rows = [json.loads(line) for line in file.read_text().splitlines()]
        name = file.stem.removeprefix(f"{platform.node()}-").partition("-")[2]
        renamed = [{**row, "host": "machine", "worker": f"machine-1-{name}"} for row in rows]
        file.with_name(f"machine-1-{name}.jsonl").write_text("".join(f"{json.dumps(row)}\n" for row in renamed))
        file.unlink()


def write_version() -> Path:
    """Write all for this version; returns the folder."""
    target = FORMATS / seoro.__version__.rpartition(".")[0]
    shutil.rmtree(target, ignore_errors=True)
    WORK.mkdir()  # fails if another process uses it
    try:
        with chdir(WORK):
            made = WORK / "made"
            made.mkdir()
            make(made)
            rename_machine(made)
            shutil.copytree(made, target)
    finally:
        shutil.rmtree(WORK)
    return target


if __name__ == "__main__":
    write_version()

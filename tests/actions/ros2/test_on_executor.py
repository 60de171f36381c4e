"""Runs on an executor, whose sandbox has no way to other processes but the router."""

from __future__ import annotations

from pathlib import Path

import seoro
from seoro.embed.options import Ros
from tests.executors import NAME, executor

SCENARIO = """import osc.ros
scenario reaches:
    do serial:
        wait_for_nodes(["/robot"])
        wait_for_data("/count", "std_msgs/msg/Int64")
        service_call("/add", "example_interfaces/srv/AddTwoInts", "{a: 1}")
"""


async def test_a_sandboxed_run_reaches_nodes_of_the_machine(robot: str, tmp_path: Path) -> None:
    file = tmp_path / "reaches.osc"
    file.write_text(SCENARIO)
    with executor(tmp_path) as lab:
        async with seoro.Client(lab.endpoint) as client:
            run = await client.submit(NAME, file, ros=Ros(robot), timeout=60.0)
            verdict = await run.result()
    assert verdict.passed, verdict

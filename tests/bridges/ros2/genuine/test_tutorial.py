"""The commands of the tutorial "Your ROS 2 robot in ten minutes", with a genuine node as the robot."""

from __future__ import annotations

import shlex
import subprocess
import sys
from pathlib import Path

import anyio
import pytest

from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2, running
from tests.bridges.ros2.genuine.test_adopt import mobile
from tests.routers import free_endpoint
from tests.tools.code_blocks import Block, blocks_in, commands_in, matches

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

PAGE = Path(__file__).parents[4] / "docs" / "tutorial" / "ros2_robot.md"


async def test_the_commands_of_the_tutorial_lead_to_a_passing_scenario(
    ros2: Ros2, router: str, tmp_path: Path
) -> None:
    bridge, blocks = free_endpoint(), list(blocks_in(PAGE))
    options = {  # the page uses default endpoints
        "seoro ros graph": ["--ros", router],
        "seoro ros adopt": ["--ros", router, "--bridge", bridge],
        "seoro bridge ros2": ["--ros", router, "--listen", bridge],
    }

    def command(line: str) -> list[str]:
        seoro, *words = shlex.split(line)
        assert seoro == "seoro"
        return [sys.executable, "-m", "seoro", *words, *options.get(" ".join([seoro, *words[:2]]), [])]

    async def type_commands(block: Block) -> None:
        for line, expected in commands_in(block):
            with anyio.fail_after(DEADLINE):
                done = await anyio.run_process(command(line), stderr=subprocess.STDOUT, check=False, cwd=tmp_path)
            output = done.stdout.decode()
            assert done.returncode == 0, output
            assert matches(expected, output), output

    for block in blocks:
        if block.name:
            (tmp_path / block.name).write_text(block.text)
    bridging = next(block for block in blocks if block.text.startswith("seoro bridge"))
    typed = [block for block in blocks if block.language == "console"]
    before, after = (
        [block for block in typed if (block.line > bridging.line) is is_after] for is_after in (False, True)
    )
    async with mobile(ros2, router):
        for block in before:
            await type_commands(block)
        [shown] = [block for block in blocks if block.language == "yaml"]
        assert shown.text in (tmp_path / "rover" / "robot.yaml").read_text()
        serve = command(bridging.text)
        async with running([word.replace("rover/", f"{tmp_path}/rover/") for word in serve], "Ctrl-C"):
            for block in after:
                await type_commands(block)

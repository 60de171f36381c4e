"""`seoro ros` and runs with `--ros` on genuine nodes, behind the routers of seoro and of rmw_zenoh."""

from __future__ import annotations

import signal
import subprocess
import sys
from pathlib import Path

import anyio
import pytest

from tests.bridges.ros2.genuine.conftest import DEADLINE, Ros2, Running, running

pytestmark = [pytest.mark.anyio, pytest.mark.ros2]

SEORO = (sys.executable, "-m", "seoro")
GOAL = ("action", "send_goal", "/fibonacci")


async def ros(router: str, *arguments: str) -> str:
    """Return the output of a command."""
    command = [*SEORO, "ros", *arguments, "--ros", router]
    with anyio.fail_after(DEADLINE):
        done = await anyio.run_process(command, stderr=subprocess.STDOUT, check=False)
    output = done.stdout.decode()
    assert done.returncode == 0, output
    return output


async def status_after(command: Running, number: signal.Signals) -> int:
    """Send a signal to a command, and return its exit status."""
    command.process.send_signal(number)
    with anyio.fail_after(DEADLINE):
        return await command.process.wait()


async def passes(folder: Path, router: str, text: str) -> None:
    """Run a scenario on the system, and assert that it passes."""
    file = folder / "main.osc"
    file.write_text(f"import osc.ros\nimport osc.helpers\nscenario main:\n    do {text}\n")
    with anyio.fail_after(DEADLINE):
        done = await anyio.run_process(
            [*SEORO, "exec", str(file), "--ros", router], stderr=subprocess.STDOUT, check=False
        )
    assert done.returncode == 0, done.stdout.decode()


async def test_commands_show_the_graph_and_its_messages(ros2: Ros2, router: str) -> None:
    async with ros2.node(router, "server"), ros2.node(router, "talker", "grüße"):
        graph = await ros(router, "graph")
        assert "  /server\n  /talker\n" in graph
        assert ["/enable", "std_srvs/srv/SetBool"] in [line.split() for line in graph.splitlines()]
        assert await ros(router, "topic", "echo", "/chatter", "-n", "1") == "data: grüße\n---\n"
        assert await ros(router, "service", "call", "/enable", "{data: true}") == "success: true\nmessage: 'on'\n"
        # types that seoro does not bring: the node is asked
        assert "string_value: HELLO\n" in await ros(router, "service", "call", "/basic", "{string_value: hello}")
        assert "42\n" in await ros(router, "topic", "echo", "/basics", "-n", "1", "--field", "int32_value")


async def test_a_signal_cancels_a_goal(ros2: Ros2, router: str) -> None:
    async with ros2.node(router, "actor", "cancels") as actor:
        command = [*SEORO, "ros", *GOAL, "{order: 600}", "--ros", router, *types(ros2)]
        async with running(command, "accepted the goal") as sent:
            await actor.printed("accepted")
            assert await status_after(sent, signal.SIGTERM) == 143
            await sent.printed("the goal was canceled")
            await actor.printed("asked to cancel")
            await actor.printed("canceled")


async def test_a_rejected_cancel_is_reported_as_rejected(ros2: Ros2, router: str) -> None:
    async with ros2.node(router, "actor") as actor:
        command = [*SEORO, "ros", *GOAL, "{order: 600}", "--ros", router, *types(ros2)]
        async with running(command, "accepted the goal") as sent:
            await actor.printed("accepted")
            assert await status_after(sent, signal.SIGTERM) == 143
            assert "its server rejects to cancel it" in await sent.printed("")


async def test_logs_are_found_by_node_names(ros2: Ros2, router: str, tmp_path: Path) -> None:
    remap = ("--ros-args", "-r", "__ns:=/bot1", "-r", "__node:=robot")
    async with ros2.node(router, "logger", "ready to dance", *remap):
        checks = ", ".join(("robot", "/bot1/robot", "bot1.robot"))
        text = "serial:\n" + "".join(f'        log_check("{name}", ["dance"])\n' for name in checks.split(", "))
        await passes(tmp_path, router, text)


def types(ros2: Ros2) -> tuple[str, str]:
    """Return the options for definitions that seoro does not contain: those of `test_msgs`."""
    return ("--interfaces", str(ros2.folder / "env" / "share"))

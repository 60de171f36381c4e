"""Actions of `osc.ros` that run programs of an installed ROS 2."""

from __future__ import annotations

import shutil
import signal
from collections.abc import Sequence
from dataclasses import dataclass

from seoro.actions.processes import Ending, run_program
from seoro.errors import ActionFailed
from seoro.runtime.actions.context import ActionContext
from seoro.runtime.functions.actions import action

ROS2 = "ros2"  # its command line


@dataclass(frozen=True)
class KeyValue:
    """The struct `key_value`."""

    key: str
    value: str


@action("ros_run")
async def ros_run(
    ctx: ActionContext,
    package_name: str,
    executable_name: str,
    wait_for_shutdown: bool,
    shutdown_timeout: float,
) -> None:
    """Run a program of a package; wait for its end, or only for its start."""
    command = ["run", package_name, executable_name]
    await _run(ctx, command, wait_for_shutdown, shutdown_timeout)


@action("ros_launch")
async def ros_launch(
    ctx: ActionContext,
    package_name: str,
    launch_file: str,
    arguments: Sequence[KeyValue],
    wait_for_shutdown: bool,
    shutdown_timeout: float,
) -> None:
    """Run a launch file; wait for its end, or only for its start."""
    for argument in arguments:
        if not argument.key or ":=" in argument.key:
            raise ActionFailed(f"invalid name of a launch argument: `{argument.key}`")
    given = [f"{argument.key}:={argument.value}" for argument in arguments]
    await _run(ctx, ["launch", package_name, launch_file, *given], wait_for_shutdown, shutdown_timeout)


async def _run(ctx: ActionContext, arguments: Sequence[str], wait: bool, timeout: float) -> None:
    if timeout < 0:
        raise ActionFailed(f"invalid `shutdown_timeout`: expected at least 0 s, found {timeout:g} s")
    if any(not word or word.startswith("-") or "\0" in word for word in arguments):
        raise ActionFailed(f"invalid command `ros2 {' '.join(arguments)}`; expected names, not options")
    if shutil.which(ROS2) is None:
        raise ActionFailed(
            "ROS 2 not found: `ros2` is not in the folders of `PATH`; source the `setup.bash` of ROS 2"
        )
    await run_program(ctx, [ROS2, *arguments], Ending(signal.SIGINT, timeout), wait=wait)

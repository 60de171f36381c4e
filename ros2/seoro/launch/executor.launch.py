"""Starts an executor, and a node by which other nodes run scenarios on it.

`ros2 launch seoro executor.launch.py scenario_dir:=scenarios`, then `ros2 service call /seoro_executor/start
std_srvs/srv/Trigger`, for example. The launched system is shut down when one of them ends.
"""

from __future__ import annotations

import shlex
from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
from launch.launch_description_entity import LaunchDescriptionEntity
from launch.substitutions import LaunchConfiguration

SEORO = Path(__file__).resolve().parents[3] / "lib" / "seoro" / "seoro"  # in the prefix of this package

# Arguments, their defaults and descriptions. The options are those of the commands.
ARGUMENTS = {
    "ros": ("tcp/127.0.0.1:7447", "Zenoh router or bridge of the system"),
    "node": ("/seoro_executor", "name of the node"),
    "name": ("local", "name of the executor"),
    "endpoint": ("tcp/127.0.0.1:7470", "Zenoh endpoint of the executor"),
    "executor_options": ("", "further options of `seoro serve`, such as --jobs 2"),
    "options": ("", "further options of `seoro ros serve`, such as --sim mujoco"),
}


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and both processes."""
    declared = [DeclareLaunchArgument("scenario_dir", description="folder of scenario files (.osc)")]
    declared += [
        DeclareLaunchArgument(name, default_value=default, description=description)
        for name, (default, description) in ARGUMENTS.items()
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=processes_of)])


def processes_of(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the processes of the executor and of the node, which waits for it."""

    def text(name: str) -> str:
        return context.perform_substitution(LaunchConfiguration(name))

    executor = [
        "serve",
        "--name",
        text("name"),
        "--listen",
        text("endpoint"),
        *shlex.split(text("executor_options")),
    ]
    node = ["ros", "serve", text("scenario_dir"), "--on", text("name"), "--executor", text("endpoint")]
    node += ["--ros", text("ros"), "--node", text("node"), *shlex.split(text("options"))]
    return [
        ExecuteProcess(
            cmd=[str(SEORO), *command],
            name=name,
            output="screen",
            on_exit=Shutdown(reason=f"{name} has ended"),
        )
        for name, command in (("executor", executor), ("node", node))
    ]

"""Runs a scenario in the ROS 2 system: `ros2 launch seoro scenario.launch.py scenario:=check_robot.osc`.

The launched system is shut down when the run ends. `test/scenario.test.py` makes the verdict the result of a test.
"""

from __future__ import annotations

import shlex
from pathlib import Path

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
from launch.conditions import IfCondition
from launch.launch_description_entity import LaunchDescriptionEntity
from launch.substitutions import LaunchConfiguration

SEORO = Path(__file__).resolve().parents[3] / "lib" / "seoro" / "seoro"  # in the prefix of this package

# Arguments, the options of `seoro exec` that they become unless they are empty or none, and their descriptions.
OPTIONS = {
    "ros": ("--ros", "Zenoh router or bridge of the system, or none"),
    "output_dir": ("--output-dir", "folder of the trace and other results"),
    "scenario_parameter_file": ("--params", "YAML file with parameters"),
    "seed": ("--seed", "random seed"),
    "sim": ("--sim", "simulator to start, or ros for the running one of the system"),
    "world": ("--world", "name or file of the world of the simulator"),
    "rate": ("--rate", "simulated seconds per second, or max"),
    "lab": ("--lab", "lab file that assigns robots to actors"),
    "timeout": ("--timeout", "end the run with an error after this wall time [s]"),
}
DEFAULTS = {"ros": "tcp/127.0.0.1:7447"}


def generate_launch_description() -> LaunchDescription:
    """Return the arguments and the run."""
    declared = [DeclareLaunchArgument("scenario", description="scenario file (.osc)")]
    declared += [
        DeclareLaunchArgument(name, default_value=DEFAULTS.get(name, ""), description=description)
        for name, (_, description) in OPTIONS.items()
    ]
    declared += [
        DeclareLaunchArgument("live_tree", default_value="false", description="show a live tree of behaviors"),
        DeclareLaunchArgument("options", default_value="", description="further options of `seoro exec`"),
        DeclareLaunchArgument("shutdown", default_value="true", description="shut down when the run ends"),
    ]
    return LaunchDescription([*declared, OpaqueFunction(function=run_of)])


def run_of(context: LaunchContext) -> list[LaunchDescriptionEntity]:
    """Return the process of the run."""

    def text(name: str) -> str:
        return context.perform_substitution(LaunchConfiguration(name))

    def is_true(name: str) -> bool:
        return IfCondition(LaunchConfiguration(name)).evaluate(context)

    command = [str(SEORO), "exec", text("scenario")]
    for name, (option, _) in OPTIONS.items():
        command += [option, text(name)] if text(name) not in ("", "none") else []
    command += ["--live-tree"] if is_true("live_tree") else []
    command += shlex.split(text("options"))
    ended = Shutdown(reason="the scenario has ended") if is_true("shutdown") else None
    return [ExecuteProcess(cmd=command, name="seoro", output="screen", on_exit=ended)]

"""Test whose result is the verdict of a scenario: `ros2 test scenario.test.py scenario:=check_robot.osc`.

It takes the arguments of `scenario.launch.py`, and its output is that of the run.
"""

from __future__ import annotations

import unittest
from pathlib import Path

from launch import LaunchDescription
from launch.actions import DeclareLaunchArgument, IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource
from launch.substitutions import LaunchConfiguration
from launch_testing import post_shutdown_test
from launch_testing.actions import ReadyToTest
from launch_testing.asserts import assertExitCodes
from launch_testing.proc_info_handler import ActiveProcInfoHandler, ProcInfoHandler
from launch_testing.util import KeepAliveProc

LAUNCH = Path(__file__).resolve().parents[1] / "launch" / "scenario.launch.py"
RUN = "seoro"  # name of its process
LONGEST = 7 * 24 * 3600.0  # [s]; the argument `timeout` of the run ends it earlier


def generate_test_description() -> LaunchDescription:
    """Return the run."""
    scenario = DeclareLaunchArgument("scenario", description="scenario file (.osc)")
    settings = {
        "scenario": LaunchConfiguration("scenario"),
        "shutdown": "false",  # the tests end the launched system
    }
    run = IncludeLaunchDescription(PythonLaunchDescriptionSource(str(LAUNCH)), launch_arguments=settings.items())
    # Without a process, the launched system would end before its tests.
    return LaunchDescription([scenario, run, KeepAliveProc(), ReadyToTest()])


class TestRun(unittest.TestCase):
    """Waits for the run."""

    def test_the_run_ends(self, proc_info: ActiveProcInfoHandler) -> None:
        """Fail if it does not end."""
        proc_info.assertWaitForShutdown(RUN, timeout=LONGEST)


@post_shutdown_test()
class TestVerdict(unittest.TestCase):
    """Judges the run."""

    def test_the_scenario_passes(self, proc_info: ProcInfoHandler) -> None:
        """Fail unless the verdict is `passed`."""
        assertExitCodes(proc_info, process=RUN)

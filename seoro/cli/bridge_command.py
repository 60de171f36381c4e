"""`seoro bridge`: stand between seoro and systems of others."""

from __future__ import annotations

import argparse
from typing import TYPE_CHECKING

from seoro.bridges.ros2.addresses import ROUTER
from seoro.cli.arguments import domain
from seoro.cli.exits import Exit
from seoro.cli.keys_arguments import add_keys_argument
from seoro.cli.robot_bridge import add_robot_arguments, run_robots
from seoro.cli.signals import Ended, ending_by_signals, status_of
from seoro.errors import InvalidUse
from seoro.terminal_text import log_to_stderr

if TYPE_CHECKING:
    from seoro.bridges.wire import SimulatorFeatures

SIMULATOR = "tcp/127.0.0.1:7450"

EXAMPLES = """examples:
  seoro sim mujoco --world maze --rate 1
  seoro bridge ros2 --expose      (in another terminal: the simulator is a ROS 2 system then)
  seoro bridge ros2 --robot turtlebot4 --ros tcp/192.168.0.7:7447
  seoro bridge ros2 --robot turtlebot4:leader@/tb1 --robot turtlebot4:follower@/tb2

It ends on Ctrl-C."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("kind", choices=["ros2"], help="what is on the other side")
    parser.add_argument(
        "--expose", action="store_true", help="show a simulator as a ROS 2 system: its robots, and the simulator"
    )
    parser.add_argument(
        "--simulator",
        metavar="ENDPOINT",
        default=SIMULATOR,
        help="with --expose: Zenoh endpoint of the simulator node (default: %(default)s)",
    )
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--ros",
        metavar="ENDPOINT",
        help=f"Zenoh endpoint of the router that the nodes of ROS 2 use (default: {ROUTER})",
    )
    place.add_argument(
        "--ros-listen", metavar="ENDPOINT", help="be that router, on this endpoint, where there is no other"
    )
    parser.add_argument(
        "--domain", metavar="N", type=domain, default=0, help="ROS_DOMAIN_ID (default: %(default)s)"
    )
    parser.add_argument(
        "--root",
        metavar="ROBOT",
        default="",
        help="with --expose: the robot that has its topics without a namespace, as if it were alone",
    )
    parser.add_argument(
        "--stamped-cmd-vel",
        action="store_true",
        help="with --expose: robots take velocities as TwistStamped, not as Twist",
    )
    add_robot_arguments(parser)
    add_keys_argument(parser)
    parser.add_argument(
        "--no-navigation",
        action="store_true",
        help="with --expose: leave it to others, such as Nav2, to localise robots and to find their ways",
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    import anyio  # noqa: PLC0415 - for this command only

    from seoro.bridges.ros2.expose.running import ExposeSettings, expose  # noqa: PLC0415 - Zenoh

    if options.expose == bool(options.robot):
        raise InvalidUse(
            "it is not said what to do",
            help="`--robot` serves robots to runs, `--expose` shows a simulator as a ROS 2 system",
        )
    log_to_stderr()
    if options.robot:
        if options.ros_listen:
            raise InvalidUse("`--ros-listen` goes with `--expose`", help="`--ros` is where the robots' router is")
        run_robots(options, options.ros or ROUTER)
        return Exit.PASSED
    if options.dialect != "auto":
        raise InvalidUse("`--dialect` goes with `--robot`", help="simulators are shown as rmw_zenoh has it")
    router = None if options.ros_listen else options.ros or ROUTER
    settings = ExposeSettings(
        options.simulator,
        router,
        options.ros_listen,
        options.domain,
        options.root,
        options.stamped_cmd_vel,
        not options.no_navigation,
    )

    def announce(features: SimulatorFeatures) -> None:
        robots = ", ".join(robot.name for robot in features.robots) or "no robots"
        where = f"at {router}" if router else f"on {options.ros_listen}"
        print(
            f"{features.engine} with {features.world or 'no world'} ({robots}) is a ROS 2 system {where}",
            flush=True,
        )

    async def serve() -> None:
        with ending_by_signals():
            await expose(settings, announce)

    try:
        anyio.run(serve)
    except Ended as ended:
        return status_of(ended.number)
    return Exit.PASSED

"""`seoro bridge`: expose a simulator as ROS 2 nodes, or ROS 2 robots to seoro."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

import anyio

from seoro.bridges.addresses import BRIDGE, ROS_ROUTER
from seoro.cli.arguments import add_dialect, add_keys_argument, add_option, domain
from seoro.cli.event_loop import fast_loop
from seoro.cli.exit_status import Exit
from seoro.cli.files import node_file
from seoro.cli.packages import ROS2, require
from seoro.cli.serving import check_name, endpoint_errors, place_of, wait_for_signal
from seoro.cli.signals import Terminated, cancel_on_signals, status_of
from seoro.errors import UsageError
from seoro.text.logs import log_to_stderr

if TYPE_CHECKING:
    from seoro.bridges.ros2.robots.profile import BridgedRobot
    from seoro.bridges.wire import SimulatorFeatures

SIMULATOR = "tcp/127.0.0.1:7450"
_NAME = "ros2"
_ROBOT = re.compile(r"(?P<profile>[^:@]+)(:(?P<name>[A-Za-z][A-Za-z0-9_-]*))?(@(?P<namespace>/?[A-Za-z0-9_/]*))?")

EXAMPLES = """examples:
  seoro sim mujoco --world maze --rate 1
  seoro bridge ros2 --expose      (in another terminal)
  seoro bridge ros2 --robot turtlebot4 --ros tcp/192.168.0.7:7447
  seoro bridge ros2 --robot turtlebot4:leader@/tb1 --robot turtlebot4:follower@/tb2

Ctrl-C ends the bridge."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument("kind", choices=["ros2"], help="kind of system to bridge to")
    add_option(parser, "--expose", "expose a simulator and its robots as ROS 2 nodes")
    add_option(
        parser,
        "--simulator ENDPOINT",
        "with --expose: Zenoh endpoint of the simulator node (default: %(default)s)",
        default=SIMULATOR,
    )
    place = parser.add_mutually_exclusive_group()
    add_option(place, "--ros ENDPOINT", f"Zenoh endpoint of the router of the ROS 2 nodes (default: {ROS_ROUTER})")
    add_option(place, "--ros-listen ENDPOINT", "with --expose: run that router at this endpoint")
    add_option(parser, "--domain N", "ROS_DOMAIN_ID (default: %(default)s)", type=domain, default=0)
    add_option(parser, "--root ROBOT", "with --expose: robot whose topics have no namespace", default="")
    add_option(parser, "--stamped-cmd-vel", "with --expose: subscribe to cmd_vel as TwistStamped instead of Twist")
    add_option(
        parser,
        "--robot PROFILE[:NAME][@NAMESPACE]",
        "serve a ROS 2 robot to runs: profile (name or file), name in scenarios (default: the model of the "
        "profile) and namespace of its topics (default: none)",
        repeatable=True,
    )
    place = parser.add_mutually_exclusive_group()
    add_option(
        place, "--listen ENDPOINT", f"with --robot: Zenoh endpoint to listen on for runs (default: {BRIDGE})"
    )
    add_option(place, "--connect ENDPOINT", "with --robot: connect to the Zenoh router at this endpoint instead")
    add_option(
        parser,
        "--name NAME",
        f"with --robot: name of the bridge in lab files (default: that of its keys, else {_NAME})",
    )
    add_dialect(parser, "with --robot: ")
    add_option(
        parser, "--ros-interfaces DIR", "with --robot: folder with more message definitions", repeatable=True
    )
    add_keys_argument(parser)
    add_option(
        parser, "--no-navigation", "with --expose: leave localisation and navigation to other nodes, such as Nav2"
    )


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    return anyio.run(_run, options, backend_options={"loop_factory": fast_loop()})


async def _run(options: argparse.Namespace) -> int:
    require("`seoro bridge`", "ros2", *ROS2)
    from seoro.bridges.ros2.expose.running import ExposeSettings, expose  # noqa: PLC0415 - Zenoh

    if options.expose == bool(options.robot):
        raise UsageError(
            "expected either `--robot` or `--expose`",
            help="`--robot` serves ROS 2 robots to runs, `--expose` exposes a simulator as ROS 2 nodes",
        )
    log_to_stderr()
    if options.robot:
        if options.ros_listen:
            raise UsageError("`--ros-listen` needs `--expose`", help="use `--ros` for the robots' router")
        await _run_robots(options, options.ros or ROS_ROUTER)
        return Exit.PASSED
    if options.dialect != "auto":
        raise UsageError("`--dialect` needs `--robot`", help="simulators are always exposed as rmw_zenoh")
    router = None if options.ros_listen else options.ros or ROS_ROUTER
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
            f"{features.engine} with {features.world or 'no world'} ({robots}) is exposed to ROS 2 {where}",
            flush=True,
        )

    try:
        with cancel_on_signals():
            await expose(settings, announce)
    except Terminated as terminated:
        return status_of(terminated.number)
    return Exit.PASSED


# ---------------------------------------------------------------- bridges to robots


async def _run_robots(options: argparse.Namespace, ros: str) -> None:
    """Run a bridge to robots until a signal ends it.

    Args:
        options: Options of the command line.
        ros: Zenoh endpoint of the router of the ROS 2 system.
    """
    from seoro.bridges.ros2.participant import RosOptions  # noqa: PLC0415 - Zenoh
    from seoro.bridges.ros2.robots.running import BridgeOptions, bridging  # noqa: PLC0415 - Zenoh and numpy
    from seoro.security.network.listener import node_name  # noqa: PLC0415 - Zenoh

    robots = _robots(options.robot)
    listen = None if options.connect else options.listen or BRIDGE
    endpoint = listen or options.connect
    name = node_name(endpoint, options.name, _NAME)
    check_name(name, "a bridge")
    dialect = None if options.dialect == "auto" else options.dialect
    settings = BridgeOptions(
        robots,
        RosOptions(ros, options.domain, dialect, options.ros_interfaces),
        name,
        listen,
        options.connect,
        node_file("bridges", name, endpoint, "stop.json"),
        node_file("bridges", name, endpoint, "audit.jsonl"),
    )

    with endpoint_errors():
        async with bridging(settings):
            names = ", ".join(robot.name for robot in robots)
            where = place_of(listen, options.connect)
            print(
                f"bridge '{name}' {where}, serving {names} of the ROS 2 system at {ros}; Ctrl-C ends it",
                flush=True,
            )
            await wait_for_signal()


def _robots(texts: Sequence[str]) -> list[BridgedRobot]:
    from seoro.bridges.ros2.robots.profile import BridgedRobot, read_profile  # noqa: PLC0415 - pydantic
    from seoro.bridges.ros2.wire.names import InvalidName, resolve_namespace  # noqa: PLC0415 - the same

    robots: list[BridgedRobot] = []
    for text in texts:
        parts = _ROBOT.fullmatch(text)
        if parts is None:
            raise UsageError(
                f"invalid `--robot {text}`: expected PROFILE[:NAME][@NAMESPACE]",
                help="for example `--robot turtlebot4:leader@/tb1`",
            )
        profile = read_profile(parts["profile"])
        name = parts["name"] or profile.model
        if any(robot.name == name for robot in robots):
            raise UsageError(f"duplicate robot name '{name}'", help="name robots: `--robot turtlebot4:leader`")
        try:
            namespace = resolve_namespace(parts["namespace"] or "")
        except InvalidName as error:
            raise UsageError(f"invalid namespace in `--robot {text}`: {error}") from error
        robots.append(BridgedRobot(name, profile, namespace))
    _check_distinct(robots)
    return robots


def _check_distinct(robots: Sequence[BridgedRobot]) -> None:
    """Check that robots have different command topics; otherwise runs would command one robot twice."""
    from seoro.bridges.ros2.wire.names import resolve  # noqa: PLC0415 - for this command only

    commanded: dict[str, str] = {}
    for robot in robots:
        for name in sorted({resolve(command, robot.namespace, "robot") for command in robot.profile.commands}):
            if name in commanded:
                raise UsageError(
                    f"'{commanded[name]}' and '{robot.name}' are the same robot: both are commanded by {name}",
                    help="give each the namespace of its topics: `--robot turtlebot4:leader@/tb1`",
                )
            commanded[name] = robot.name

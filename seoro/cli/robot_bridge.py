"""`seoro bridge ros2 --robot`: the options of a bridge to robots, and running it."""

from __future__ import annotations

import argparse
import re
from collections.abc import Sequence
from typing import TYPE_CHECKING

from seoro.cli.arguments import add_dialect, add_folders
from seoro.cli.files import node_file
from seoro.cli.signals import ending_signals
from seoro.errors import InvalidUse

if TYPE_CHECKING:
    from seoro.bridges.ros2.robots.running import BridgedRobot

LISTEN = "tcp/127.0.0.1:7460"
NAME = "ros2"
_ROBOT = re.compile(r"(?P<profile>[^:@]+)(:(?P<name>[A-Za-z][A-Za-z0-9_-]*))?(@(?P<namespace>/?[A-Za-z0-9_/]*))?")


def add_robot_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "--robot",
        action="append",
        default=[],
        metavar="PROFILE[:NAME][@NAMESPACE]",
        help="serve a robot of ROS 2 to runs: the profile or its file, the name for scenarios (default: the model "
        "of the profile), and the namespace of its topics (default: none) (repeatable)",
    )
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--listen", metavar="ENDPOINT", help=f"with --robot: listen there for runs (default: {LISTEN})"
    )
    place.add_argument(
        "--connect", metavar="ENDPOINT", help="with --robot: be reached by runs over the Zenoh router there"
    )
    parser.add_argument(
        "--name", help=f"with --robot: name of the bridge, for lab files (default: that in its keys, else {NAME})"
    )
    add_dialect(parser, "with --robot: ")
    add_folders(parser, "--ros-interfaces", "with --robot: definitions of messages that seoro does not bring")


def run_robots(options: argparse.Namespace, ros: str) -> None:
    """Bridge robots until the process is told to end.

    Args:
        options: Of the command line.
        ros: Zenoh endpoint of the router of the ROS 2 system.
    """
    import anyio  # noqa: PLC0415 - for this command only

    from seoro.bridges.door import node_name  # noqa: PLC0415 - Zenoh
    from seoro.bridges.ros2.robots.running import BridgeOptions, bridging  # noqa: PLC0415 - Zenoh and numpy
    from seoro.bridges.session import SessionError  # noqa: PLC0415 - the same

    robots = _robots(options.robot)
    listen = None if options.connect else options.listen or LISTEN
    endpoint = listen or options.connect
    name = node_name(endpoint, options.name, NAME)
    if re.fullmatch(r"[a-z0-9_-]+", name) is None:
        raise InvalidUse(f"'{name}' cannot name a bridge: use lower-case letters, digits, '_' and '-'")
    settings = BridgeOptions(
        robots,
        ros,
        options.domain,
        options.ros_interfaces,
        name,
        listen,
        options.connect,
        node_file("bridges", name, endpoint, "stop.json"),
        node_file("bridges", name, endpoint, "audit.jsonl"),
        None if options.dialect == "auto" else options.dialect,
    )

    async def serve() -> None:
        async with bridging(settings):
            names = ", ".join(robot.name for robot in robots)
            where = f"listens on {listen}" if listen else f"is connected to {options.connect}"
            print(f"the bridge '{name}' {where} with {names}, reached at {ros}; Ctrl-C ends it", flush=True)
            with anyio.open_signal_receiver(*ending_signals()) as signals:
                async for _ in signals:
                    return

    try:
        anyio.run(serve)
    except SessionError as error:
        raise InvalidUse(str(error), help="`--listen` or `--connect` says where runs reach the bridge") from error


def _robots(texts: Sequence[str]) -> list[BridgedRobot]:
    from seoro.bridges.ros2.robots.profile import read_profile  # noqa: PLC0415 - the form of profiles
    from seoro.bridges.ros2.robots.running import BridgedRobot  # noqa: PLC0415 - Zenoh and numpy
    from seoro.bridges.ros2.wire.names import InvalidName, resolve_namespace  # noqa: PLC0415 - the same

    robots: list[BridgedRobot] = []
    for text in texts:
        parts = _ROBOT.fullmatch(text)
        if parts is None:
            raise InvalidUse(
                f"`--robot {text}` is not of the form PROFILE[:NAME][@NAMESPACE]",
                help="such as `--robot turtlebot4:leader@/tb1`",
            )
        profile = read_profile(parts["profile"])
        name = parts["name"] or profile.model
        if any(robot.name == name for robot in robots):
            raise InvalidUse(
                f"two robots are called '{name}'", help="give them names: `--robot turtlebot4:leader`"
            )
        try:
            namespace = resolve_namespace(parts["namespace"] or "")
        except InvalidName as error:
            raise InvalidUse(f"`--robot {text}` has no namespace of ROS 2: {error}") from error
        robots.append(BridgedRobot(name, profile, namespace))
    _check_apart(robots)
    return robots


def _check_apart(robots: Sequence[BridgedRobot]) -> None:
    """Refuse two names for one robot, which runs would command at the same time."""
    from seoro.bridges.ros2.wire.names import resolve  # noqa: PLC0415 - for this command only

    commanded: dict[str, str] = {}
    for robot in robots:
        for name in sorted({resolve(command, robot.namespace, "robot") for command in robot.profile.commands}):
            if name in commanded:
                raise InvalidUse(
                    f"'{commanded[name]}' and '{robot.name}' are one robot: {name} commands both",
                    help="say in which namespace each has its topics: `--robot turtlebot4:leader@/tb1`",
                )
            commanded[name] = robot.name

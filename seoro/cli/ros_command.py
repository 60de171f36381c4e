"""`seoro ros`: look at a ROS 2 system, and talk to it, without an installation of ROS."""

from __future__ import annotations

import argparse
import asyncio
import os
from collections.abc import Awaitable, Callable, Iterator
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import TypeAlias

from seoro.bridges.ros2.addresses import ROUTER
from seoro.cli.arguments import add_dialect, add_folders, domain, number, whole
from seoro.cli.exits import Exit
from seoro.cli.signals import Ended, ending_by_signals, status_of
from seoro.errors import InvalidUse

Kinds: TypeAlias = "argparse._SubParsersAction[argparse.ArgumentParser]"

PRESETS = (
    "sensor_data",
    "system_default",
    "system_default_reliable",
    "system_default_transient_local",
    "services_default",
    "parameters",
    "parameter_events",
)

ENDLESS = ("topics.echo", "topics.measure_rate", "topics.publish", "bags.record_topics")  # until a signal

EXAMPLES = """examples:
  seoro ros graph
  seoro ros graph --node /controller_server
  seoro ros topic echo /odom --member pose.pose.position --count 1
  seoro ros topic hz /scan --ros tcp/192.168.0.7:7447
  seoro ros topic pub /cmd_vel '{linear: {x: 0.2}}' --rate 10
  seoro ros service call /reinitialize_global_localization ''
  seoro ros action send /navigate_to_pose '{pose: {header: {frame_id: map}, pose: {position: {x: 1.0}}}}'
  seoro ros param set /amcl max_particles 3000
  seoro ros bag record /scan /odom /tf /tf_static -o out/drive
  seoro ros bag play out/drive --topic /scan --rate 2

`seoro ros topic --help` and so on say more.

exit status: 0; 1 if a goal was rejected, aborted or canceled; 2 if what was asked for is wrong or not there; 3 if
the system is not reached, or does not answer; 130 (Ctrl-C), 143 (SIGTERM) or 129 (SIGHUP) if a signal ended what
would have ended by itself. A signal cancels the goal that was sent, and completes the bag that is recorded."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    kinds = parser.add_subparsers(title="things", metavar="THING", required=True)
    _add_graph(_leaf(kinds, "graph", "nodes, topics, services and actions", "graph.show"))
    _add_topics(_branch(kinds, "topic", "who publishes what; echo, rates, publishing"))
    _add_services(_branch(kinds, "service", "services, and calling them"))
    _add_actions(_branch(kinds, "action", "actions, and sending goals"))
    _add_parameters(_branch(kinds, "param", "parameters of nodes"))
    _add_bags(_branch(kinds, "bag", "recording topics into bags, and playing them"))


def _branch(kinds: Kinds, name: str, what: str) -> Kinds:
    parser = kinds.add_parser(name, help=what, description=f"{what[0].upper()}{what[1:]}.", allow_abbrev=False)
    return parser.add_subparsers(title="commands", metavar="COMMAND", required=True)


def _leaf(kinds: Kinds, name: str, what: str, act: str) -> argparse.ArgumentParser:
    parser = kinds.add_parser(name, help=what, description=f"{what[0].upper()}{what[1:]}.", allow_abbrev=False)
    system = parser.add_argument_group("the system")
    system.add_argument(
        "--ros", metavar="ENDPOINT", default=ROUTER, help=f"Zenoh endpoint of its router (default: {ROUTER})"
    )
    system.add_argument(
        "--domain", type=_domain, metavar="N", default=None, help="domain (default: ROS_DOMAIN_ID, else 0)"
    )
    add_dialect(system)
    add_folders(system, "--interfaces", "definitions of its own: PACKAGE/msg/X.msg, srv and action likewise")
    system.add_argument(
        "--distribution",
        metavar="NAME",
        default="jazzy",
        help="ROS 2 distribution of definitions (default: jazzy)",
    )
    parser.add_argument("--debug", action="store_true", default=argparse.SUPPRESS, help=argparse.SUPPRESS)
    parser.set_defaults(act=act, parser=parser)
    return parser


def _add_graph(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--node", metavar="NODE", help="what one node has, and its lifecycle state")
    _add_hidden(parser)
    _add_json(parser)


def _add_topics(topics: Kinds) -> None:
    listing = _leaf(topics, "list", "list topics with their types", "topics.list_topics")
    _add_hidden(listing)
    _add_json(listing)
    info = _leaf(topics, "info", "tell who publishes and subscribes, with quality of service", "topics.show_info")
    info.add_argument("name", metavar="TOPIC")
    echo = _leaf(topics, "echo", "print messages as they come", "topics.echo")
    rate = _leaf(topics, "hz", "measure at which rate messages come", "topics.measure_rate")
    for parser in (echo, rate):
        parser.add_argument("name", metavar="TOPIC")
        _add_type(parser)
        _add_qos(parser, "what its publishers offer")
        parser.add_argument("-n", "--count", type=whole, default=0, metavar="N", help="end after N messages")
    rate.add_argument("--window", type=whole, default=0, metavar="N", help="of the last N messages only")
    echo.add_argument("--member", metavar="PATH", help="print this member only: `pose.position.x`, `ranges.0`")
    _add_form(echo)
    publishing = _leaf(topics, "pub", "publish a message", "topics.publish")
    publishing.add_argument("name", metavar="TOPIC")
    publishing.add_argument("value", metavar="VALUE", help="YAML; members that are left out have their defaults")
    _add_type(publishing)
    _add_qos(publishing, "reliable, volatile, keeps 10")
    publishing.add_argument("-r", "--rate", type=_positive, metavar="HZ", help="again and again, at this rate")
    publishing.add_argument(
        "-n",
        "--count",
        type=whole,
        default=0,
        metavar="N",
        help="so many times (default: once, or without end)",
    )
    publishing.add_argument(
        "--wait", type=_seconds, default=3.0, metavar="SECONDS", help="for somebody to subscribe (default: 3)"
    )


def _add_services(services: Kinds) -> None:
    listing = _leaf(services, "list", "list services with their types", "services.list_services")
    _add_hidden(listing)
    _add_json(listing)
    calling = _leaf(services, "call", "call a service", "services.call")
    calling.add_argument("name", metavar="SERVICE")
    calling.add_argument("value", metavar="VALUE", nargs="?", default="", help="the request as YAML")
    _add_type(calling)
    calling.add_argument(
        "--timeout", type=_positive, default=10.0, metavar="SECONDS", help="for the response (default: 10)"
    )
    _add_form(calling)


def _add_actions(actions: Kinds) -> None:
    listing = _leaf(actions, "list", "list actions with their types", "actions.list_actions")
    _add_json(listing)
    sending = _leaf(actions, "send", "send a goal, and wait for its end; a signal cancels it", "actions.send")
    sending.add_argument("name", metavar="ACTION")
    sending.add_argument("value", metavar="VALUE", nargs="?", default="", help="the goal as YAML")
    sending.add_argument("--feedback", action="store_true", help="print what is told on the way")
    _add_type(sending)
    _add_form(sending)


def _add_parameters(parameters: Kinds) -> None:
    getting = _leaf(parameters, "get", "print parameters with their values", "parameters.show")
    getting.add_argument("node", metavar="NODE")
    getting.add_argument("names", metavar="NAME", nargs="*", help="of parameters (default: all)")
    _add_form(getting)
    setting = _leaf(parameters, "set", "set a parameter", "parameters.change")
    setting.add_argument("node", metavar="NODE")
    setting.add_argument("name", metavar="NAME")
    setting.add_argument("value", metavar="VALUE", help="YAML: true, 0.5, text, [1, 2]")


def _add_bags(bags: Kinds) -> None:
    recording = _leaf(bags, "record", "record topics until Ctrl-C", "bags.record_topics")
    recording.add_argument("names", metavar="TOPIC", nargs="*", help="topics that have to be there")
    recording.add_argument("--pattern", metavar="REGEX", help="topics whose full names match, when they are there")
    recording.add_argument("-o", "--output", type=Path, metavar="DIR", help="the bag (default: rosbag2_DATE-TIME)")
    recording.add_argument("--duration", type=_positive, metavar="SECONDS", help="end after that time")
    recording.add_argument("--use-sim-time", action="store_true", help="messages have the time of /clock")
    recording.add_argument(
        "--compression", choices=("none", "lz4", "zstd"), default="none", help="of the messages (default: none)"
    )
    _add_hidden(recording, ", and all topics if none is named and there is no pattern")
    playing = _leaf(bags, "play", "publish what is in a bag", "bags.play_bag")
    playing.add_argument("bag", type=Path, metavar="BAG", help="a folder as rosbag2 makes it, or a file")
    playing.add_argument(
        "--topic", action="append", default=[], metavar="TOPIC", help="this topic only (repeatable)"
    )
    playing.add_argument("-r", "--rate", type=_positive, default=1.0, metavar="N", help="so fast (default: 1)")
    playing.add_argument(
        "--start-offset", type=_seconds, default=0.0, metavar="SECONDS", help="leave out the beginning"
    )
    playing.add_argument("--clock", type=_positive, metavar="HZ", help="publish /clock, at this rate")


def _add_hidden(parser: argparse.ArgumentParser, more: str = "") -> None:
    parser.add_argument("--all", action="store_true", help=f"hidden ones, too, whose names begin with `_`{more}")


def _add_json(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--json", action="store_true", help="print JSON")


def _add_form(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--full", action="store_true", help="do not cut off long lists and texts")
    _add_json(parser)


def _add_type(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--type", metavar="TYPE", help="its type (default: what it has in the system)")


def _add_qos(parser: argparse.ArgumentParser, default: str) -> None:
    parser.add_argument("--qos", choices=PRESETS, help=f"a preset of quality of service (default: {default})")


def run(options: argparse.Namespace) -> int:
    """Run the command."""
    for missing in _missing():
        raise InvalidUse(f"`seoro ros` needs the package {missing}", help="pip install 'seoro[ros2]'")
    if options.domain is None:
        options.domain = _domain_of_environment()
    module, _, function = options.act.partition(".")
    act = getattr(import_module(f"seoro.cli.ros.{module}"), function)
    try:
        return asyncio.run(_until_signal(act, options))
    except Ended as ended:
        return Exit.PASSED if options.act in ENDLESS else status_of(ended.number)


async def _until_signal(act: Callable[[argparse.Namespace], Awaitable[int]], options: argparse.Namespace) -> int:
    with ending_by_signals():
        return int(await act(options))


def _missing() -> Iterator[str]:
    return (name for name in ("mcap", "rosbags", "xxhash") if find_spec(name) is None)


def _domain_of_environment() -> int:
    text = os.environ.get("ROS_DOMAIN_ID", "").strip() or "0"
    try:
        return _domain(text)
    except argparse.ArgumentTypeError as error:
        raise InvalidUse(f"the environment variable ROS_DOMAIN_ID is wrong: {error}") from None


def _domain(text: str) -> int:
    return domain(text, "domain")


def _positive(text: str) -> float:
    value = _seconds(text)
    if value <= 0.0:
        raise argparse.ArgumentTypeError(f"expected a number above 0, not {text!r}")
    return value


def _seconds(text: str) -> float:
    return number(text, "a number from 0", lambda value: value >= 0.0)

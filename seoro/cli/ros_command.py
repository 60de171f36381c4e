"""`seoro ros`: inspect and use a ROS 2 system without an installation of ROS."""

from __future__ import annotations

import argparse
import os
from importlib import import_module
from pathlib import Path

from seoro.bridges.addresses import BRIDGE, ROS_ROUTER
from seoro.cli.arguments import Commands, add_command, add_dialect, add_option, domain, pattern, positive, seconds
from seoro.cli.exit_status import Exit
from seoro.cli.packages import ROS2, require
from seoro.cli.remote_arguments import add_on_arguments
from seoro.cli.run_arguments import add_lease_arguments, add_run_arguments
from seoro.cli.signals import Terminated, cancel_on_signals, status_of
from seoro.errors import UsageError

RUNS_NODE = "/seoro_executor"
PRESETS = (
    "sensor_data",
    "system_default",
    "system_default_reliable",
    "system_default_transient_local",
    "services_default",
    "parameters",
    "parameter_events",
)

SERVE = "serve.serve"
ENDLESS = (SERVE, "topics.echo", "topics.measure_rate", "topics.publish", "bags.record_topics")  # end by a signal

EXAMPLES = """examples:
  seoro ros graph
  seoro ros graph --node /controller_server
  seoro ros adopt -o robot/
  seoro ros topic echo /odom --field pose.pose.position --count 1
  seoro ros topic hz /scan --ros tcp/192.168.0.7:7447
  seoro ros topic pub /cmd_vel '{linear: {x: 0.2}}' --rate 10
  seoro ros service call /reinitialize_global_localization ''
  seoro ros action send_goal /navigate_to_pose '{pose: {header: {frame_id: map}, pose: {position: {x: 1.0}}}}'
  seoro ros param set /amcl max_particles 3000
  seoro ros bag record /scan /odom /tf /tf_static -o out/drive
  seoro ros bag play out/drive --topic /scan --rate 2
  seoro ros serve scenarios/ --on lab-a

`seoro ros topic --help` and `seoro ros topic echo --help` list the subcommands and options.

exit status: 0 success, 1 goal rejected, aborted or canceled, 2 invalid arguments or unknown name, 3 system
unreachable or no answer, 130 (Ctrl-C), 143 (SIGTERM) or 129 (SIGHUP) if a signal ended a command that ends by
itself. A signal cancels a sent goal, completes a recorded bag, and stops served runs."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    kinds = parser.add_subparsers(title="subcommands", metavar="SUBCOMMAND", required=True)
    _add_graph(_leaf(kinds, "graph", "list nodes, topics, services and actions", "graph.show"))
    _add_adopt(_leaf(kinds, "adopt", "write a lab file and profiles for the robots of the system", "adopt.adopt"))
    _add_serve(kinds)
    _add_topics(_branch(kinds, "topic", "list, echo, measure and publish topics"))
    _add_services(_branch(kinds, "service", "list and call services"))
    _add_actions(_branch(kinds, "action", "list actions and send goals"))
    _add_parameters(_branch(kinds, "param", "get and set parameters of nodes"))
    _add_bags(_branch(kinds, "bag", "record topics into bags and play bags"))


def _branch(kinds: Commands, name: str, what: str) -> Commands:
    parser = add_command(kinds, name, what)
    return parser.add_subparsers(title="commands", metavar="COMMAND", required=True)


def _leaf(kinds: Commands, name: str, what: str, act: str, place: str = "") -> argparse.ArgumentParser:
    """Add a command.

    Args:
        kinds: Commands of the same kind.
        name: Name of the command.
        what: Description.
        act: Module and function in `seoro.cli.ros` that run it.
        place: Placeholder of its first argument, `name`, if any.
    """
    parser = add_command(kinds, name, what)
    system = parser.add_argument_group("ROS 2 system")
    add_option(
        system,
        "--ros ENDPOINT",
        f"Zenoh endpoint of the router or bridge (default: {ROS_ROUTER})",
        default=ROS_ROUTER,
    )
    add_option(system, "--domain N", "domain ID (default: ROS_DOMAIN_ID, else 0)", type=domain)
    add_dialect(system)
    add_option(
        system,
        "--interfaces DIR",
        "folder with more interface definitions: PACKAGE/msg/X.msg, PACKAGE/srv/X.srv, ...",
        repeatable=True,
    )
    add_option(
        system,
        "--distribution NAME",
        "ROS 2 distribution of the interface definitions (default: jazzy)",
        default="jazzy",
    )
    parser.set_defaults(act=act)
    if place:
        parser.add_argument("name", metavar=place)
    return parser


def _add_graph(parser: argparse.ArgumentParser) -> None:
    add_option(parser, "--node NODE", "show only this node, with its lifecycle state")
    _add_hidden(parser)
    _add_json(parser)


def _add_adopt(parser: argparse.ArgumentParser) -> None:
    add_option(parser, "-o --output DIR", "folder of the files (default: the current one)", default=".")
    add_option(parser, "--namespace NAMESPACE", "adopt only the robot of this namespace")
    add_option(
        parser, "--bridge ENDPOINT", f"endpoint of the bridge in the lab file (default: {BRIDGE})", default=BRIDGE
    )
    add_option(parser, "--force", "overwrite files")
    add_option(parser, "--yes", "ask nothing: write defaults for missing values, marked with CHECK")


def _add_serve(kinds: Commands) -> None:
    """Declare the command that serves runs; its runs have the options of `seoro exec`."""
    parser = add_command(
        kinds, "serve", "let nodes of the system start and stop scenarios of folders on an executor"
    )
    parser.add_argument("folders", metavar="DIR", nargs="+", type=Path, help="folder of scenario files (.osc)")
    add_option(parser, "--node NAME", f"name of the node (default: {RUNS_NODE})", default=RUNS_NODE)
    add_run_arguments(parser)
    add_on_arguments(parser)
    add_lease_arguments(parser)
    parser.set_defaults(act=SERVE, domain=0, ros=ROS_ROUTER)


def _add_list(kinds: Commands, listed: str) -> None:
    parser = _leaf(kinds, "list", f"list {listed} with their types", "graph.list_types")
    parser.set_defaults(listed=listed)
    if listed != "actions":  # no action is hidden
        _add_hidden(parser)
    _add_json(parser)


def _add_topics(topics: Commands) -> None:
    _add_list(topics, "topics")
    _add_json(_leaf(topics, "info", "show publishers and subscriptions with QoS", "topics.show_info", "TOPIC"))
    echo = _leaf(topics, "echo", "print messages as they arrive", "topics.echo", "TOPIC")
    rate = _leaf(topics, "hz", "measure the rate of messages", "topics.measure_rate", "TOPIC")
    for parser in (echo, rate):
        parser.add_argument("type", metavar="TYPE", nargs="?", help="type (default: its type in the system)")
        _add_qos(parser, "that of the publishers")
        add_option(parser, "-n --count N", "end after N messages", default=0)
    add_option(rate, "--window N", "use only the last N messages", default=0)
    add_option(rate, "--json", "print a JSON object once a second: rate [Hz], bandwidth [byte/s], intervals [s]")
    add_option(echo, "--field PATH", "print this field only: `pose.position.x`, `ranges.0`")
    _add_form(echo)
    publishing = _leaf(topics, "pub", "publish a message", "topics.publish", "TOPIC")
    _add_value(publishing, "message as YAML; omitted fields have their defaults", is_required=True)
    _add_qos(publishing, "reliable, volatile, depth 10")
    add_option(publishing, "-r --rate HZ", "publish repeatedly at this rate")
    add_option(publishing, "-n --count N", "number of messages (default: 1; with --rate: unlimited)", default=0)
    add_option(
        publishing,
        "--wait SECONDS",
        "wait for a subscription at most this long (default: 3)",
        type=seconds,
        default=3.0,
    )


def _add_services(services: Commands) -> None:
    _add_list(services, "services")
    calling = _leaf(services, "call", "call a service", "requests.call_service", "SERVICE")
    _add_value(calling, "request as YAML")
    add_option(calling, "--timeout SECONDS", "wait for the response at most this long (default: 10)", default=10.0)
    _add_form(calling)


def _add_actions(actions: Commands) -> None:
    _add_list(actions, "actions")
    sending = _leaf(
        actions,
        "send_goal",
        "send a goal and wait for its result; a signal cancels it",
        "requests.send_goal",
        "ACTION",
    )
    _add_value(sending, "goal as YAML")
    add_option(sending, "--feedback", "print feedback")
    _add_form(sending)


def _add_parameters(parameters: Commands) -> None:
    getting = _leaf(parameters, "get", "print parameters", "requests.show_parameters")
    getting.add_argument("node", metavar="NODE")
    getting.add_argument("names", metavar="NAME", nargs="*", help="names of parameters (default: all)")
    _add_form(getting)
    setting = _leaf(parameters, "set", "set a parameter", "requests.set_parameter_value")
    setting.add_argument("node", metavar="NODE")
    setting.add_argument("name", metavar="NAME")
    setting.add_argument("value", metavar="VALUE", help="value as YAML: true, 0.5, text, [1, 2]")


def _add_bags(bags: Commands) -> None:
    recording = _leaf(bags, "record", "record topics until Ctrl-C", "bags.record_topics")
    recording.add_argument("names", metavar="TOPIC", nargs="*", help="topics to wait for and record")
    add_option(
        recording, "--pattern REGEX", "also record topics whose full names match, as they appear", type=_pattern
    )
    add_option(recording, "-o --output DIR", "output folder (default: rosbag2_DATE-TIME)")
    add_option(recording, "--duration SECONDS", "stop after this time")
    add_option(recording, "--use-sim-time", "use the time of /clock for messages")
    add_option(
        recording,
        "--compression",
        "compression of messages (default: none)",
        choices=("none", "lz4", "zstd"),
        default="none",
    )
    add_option(
        recording, "--storage", "format of the bag (default: mcap)", choices=("mcap", "sqlite3"), default="mcap"
    )
    _add_hidden(recording, "; without TOPIC and --pattern, record all topics")
    playing = _leaf(bags, "play", "publish the messages of a bag", "bags.play_bag")
    playing.add_argument("bag", type=Path, metavar="BAG", help="rosbag2 folder, or file (.mcap or .db3)")
    add_option(playing, "--topic TOPIC", "play only this topic", repeatable=True)
    add_option(playing, "-r --rate N", "speed factor (default: 1)", type=positive, default=1.0)
    add_option(playing, "--start-offset SECONDS", "skip the first seconds", type=seconds, default=0.0)
    add_option(playing, "--clock HZ", "publish /clock at this rate")


def _add_hidden(parser: argparse.ArgumentParser, more: str = "") -> None:
    add_option(parser, "--all", f"include hidden names, which begin with `_`{more}")


def _add_json(parser: argparse.ArgumentParser) -> None:
    add_option(parser, "--json", "print JSON")


def _add_form(parser: argparse.ArgumentParser) -> None:
    add_option(parser, "--full", "do not shorten long lists and texts")
    _add_json(parser)


def _add_value(parser: argparse.ArgumentParser, what: str, *, is_required: bool = False) -> None:
    """Declare a type and a value, as in `ros2`; the type is optional."""
    parser.add_argument(
        "words",
        metavar=("TYPE", "VALUE"),
        nargs="+" if is_required else "*",
        help=f"type (default: its type in the system), and {what}",
    )


def _add_qos(parser: argparse.ArgumentParser, default: str) -> None:
    add_option(parser, "--qos", f"QoS preset (default: {default})", choices=PRESETS)


async def run(options: argparse.Namespace) -> int:
    """Run the command."""
    require("`seoro ros`", "ros2", *ROS2)
    if options.domain is None:
        options.domain = _domain_of_environment()
    module, _, function = options.act.partition(".")
    act = getattr(import_module(f"seoro.cli.ros.{module}"), function)
    try:
        with cancel_on_signals():
            return int(await act(options))
    except Terminated as terminated:
        return Exit.PASSED if options.act in ENDLESS else status_of(terminated.number)


def _domain_of_environment() -> int:
    text = os.environ.get("ROS_DOMAIN_ID", "").strip() or "0"
    try:
        return domain(text)
    except argparse.ArgumentTypeError as error:
        raise UsageError(f"environment variable ROS_DOMAIN_ID: {error}") from None


def _pattern(text: str) -> str:
    return pattern(text).pattern

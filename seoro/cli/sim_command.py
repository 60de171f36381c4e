"""`seoro sim`: start a simulator node, or inspect a robot."""

from __future__ import annotations

import argparse
import os
import sys
from typing import NoReturn

from seoro.cli.arguments import add_keys_argument, add_option, option_texts, rate, seed
from seoro.cli.files import node_file
from seoro.errors import UsageError

INSPECT = "inspect"
DEFAULT_WORLD = "maze"
DEFAULT_ENDPOINT = "tcp/127.0.0.1:7450"

EXAMPLES = """examples:
  seoro sim mujoco --world maze
  seoro exec obstacle.osc --connect tcp/127.0.0.1:7450      (in another terminal)
  seoro sim --from-snapshot out/entrance.snapshot --rate 1
  seoro sim inspect robot.urdf
  seoro sim inspect robot.urdf --declaration > robot.yaml

Ctrl-C ends the simulator."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "name",
        nargs="?",
        metavar="SIMULATOR",
        help="simulator: mujoco, pybullet, or that of an installed package (default: that of the snapshot); "
        "`inspect` to describe a robot instead",
    )
    parser.add_argument(
        "model",
        nargs="?",
        metavar="MODEL",
        help="with `inspect`: model of a robot (URDF, SDF or MJCF), declaration (.yaml), or name of a robot",
    )
    add_option(parser, "--world WORLD", f"name or file of the world (default: {DEFAULT_WORLD})")
    add_option(
        parser, "--from-snapshot FILE", "continue from a saved state, with its world, clock and robot commands"
    )
    add_option(parser, "--seed N", "random seed (default: 0, or that of the snapshot)", type=seed)
    place = parser.add_mutually_exclusive_group()
    add_option(place, "--listen ENDPOINT", f"Zenoh endpoint to listen on (default: {DEFAULT_ENDPOINT})")
    add_option(place, "--connect ENDPOINT", "connect to the Zenoh router at this endpoint instead")
    add_option(
        parser,
        "--node NODE",
        "name of the node, as in lab files with several nodes behind one router (default: that of its keys, "
        "else NAME)",
    )
    add_option(
        parser,
        "--rate RATE",
        "start unpaused at this rate (1 = real time, max = as fast as possible; default: paused until a run "
        "advances time)",
        type=rate,
    )
    add_option(parser, "--drive KIND", "with `inspect`: kind of drive (default: by the wheels of the model)")
    form = parser.add_mutually_exclusive_group()
    form.add_argument("--json", action="store_true", help="with `inspect`: print JSON")
    form.add_argument(
        "--declaration", action="store_true", help="with `inspect`: print a declaration to start from"
    )
    add_keys_argument(parser)
    add_option(
        parser,
        "--model-path DIR",
        "folder to search first for models `name://path`, as DIR/name/path",
        repeatable=True,
    )


def run(options: argparse.Namespace) -> int:
    """Run the command: replace this process by the node."""
    from seoro.bridges.launch import check_installed  # noqa: PLC0415 - the same
    from seoro.bridges.session import is_secured  # noqa: PLC0415 - the same
    from seoro.security.network.listener import node_name  # noqa: PLC0415 - Zenoh, for this command only

    if options.name == INSPECT:
        _inspect(options)
    _check_inspection_only(options)
    name, arguments = _initial_state(options)
    check_installed(name)
    endpoint = options.connect or options.listen or DEFAULT_ENDPOINT
    if is_secured(endpoint):
        options.node = node_name(endpoint, options.node, name)
        arguments += ["--audit", str(node_file("simulators", options.node, endpoint, "audit.jsonl"))]
    arguments += option_texts(options, ("seed", "listen", "connect", "node", "rate", "model_path"))
    arguments += ["--stop-file", str(node_file("simulators", options.node or name, endpoint, "stop.json"))]
    os.execv(sys.executable, [sys.executable, "-m", "sim_nodes", name, *arguments])  # noqa: S606


def _inspect(options: argparse.Namespace) -> NoReturn:
    """Replace this process by the inspection.

    Raises:
        UsageError: The model is missing.
    """
    if options.model is None:
        raise UsageError("missing model to inspect", help="for example `seoro sim inspect robot.urdf`")
    arguments = [options.model, *option_texts(options, ("drive",))]
    arguments += [f"--{form}" for form in ("json", "declaration") if getattr(options, form)]
    os.execv(sys.executable, [sys.executable, "-m", "sim_nodes", INSPECT, *arguments])  # noqa: S606


def _check_inspection_only(options: argparse.Namespace) -> None:
    """Refuse what belongs to `inspect`.

    Raises:
        UsageError: There is such an argument.
    """
    given = (f"--{name}" for name in ("drive", "json", "declaration") if getattr(options, name))
    found = options.model or next(given, None)
    if found is not None:
        raise UsageError(
            f"unexpected argument `{found}`: only `seoro sim inspect MODEL` takes it",
            help="see `seoro sim --help`",
        )


def _initial_state(options: argparse.Namespace) -> tuple[str, list[str]]:
    """Return the simulator, and its arguments for the initial state.

    Raises:
        UsageError: The simulator is missing, or options contradict each other.
    """
    path = options.from_snapshot
    if path is None:
        if options.name is None:
            raise UsageError("missing name of a simulator", help="for example `seoro sim mujoco`")
        return options.name, ["--world", options.world or DEFAULT_WORLD]
    from seoro.bridges.snapshots import read_snapshot  # noqa: PLC0415 - the messages of simulators

    if options.world is not None:
        raise UsageError("`--world` contradicts `--from-snapshot`", help="leave out one of them")
    snapshot = read_snapshot(path)
    if options.name not in (None, snapshot.engine):
        raise UsageError(
            f"{path} is a snapshot of {snapshot.engine}, not of {options.name}",
            help=f"leave out `{options.name}`, or use `{snapshot.engine}`",
        )
    return snapshot.engine, ["--from-snapshot", str(path)]

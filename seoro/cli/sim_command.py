"""`seoro sim`: start a simulator node by hand."""

from __future__ import annotations

import argparse
import os
import sys
from pathlib import Path

from seoro.cli.arguments import add_folders, rate, seed
from seoro.cli.files import node_file
from seoro.cli.keys_arguments import add_keys_argument
from seoro.errors import InvalidUse

DEFAULT_WORLD = "maze"
DEFAULT_ENDPOINT = "tcp/127.0.0.1:7450"

EXAMPLES = """examples:
  seoro sim mujoco --world maze
  seoro exec obstacle.osc --connect tcp/127.0.0.1:7450      (in another terminal)
  seoro sim --from-snapshot out/entrance.snapshot --rate 1

It ends on Ctrl-C."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "name",
        nargs="?",
        metavar="NAME",
        help="the simulator: mujoco, pybullet, or one that an installed package brings (default: the one that "
        "saved the snapshot)",
    )
    parser.add_argument("--world", metavar="WORLD", help=f"name or file of the world (default: {DEFAULT_WORLD})")
    parser.add_argument(
        "--from-snapshot",
        type=Path,
        metavar="FILE",
        help="go on from the state that a run has saved, with its world, its clock and what its robots do",
    )
    parser.add_argument(
        "--seed",
        type=seed,
        metavar="N",
        help="seed of all it draws (default: 0, or what a snapshot goes on with)",
    )
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--listen", metavar="ENDPOINT", help=f"Zenoh endpoint to listen on (default: {DEFAULT_ENDPOINT})"
    )
    place.add_argument("--connect", metavar="ENDPOINT", help="be reached over the Zenoh router there")
    parser.add_argument(
        "--node",
        metavar="NODE",
        help="what lab files call it by `name`, where several are reached over one router (default: that in its "
        "keys, else NAME)",
    )
    parser.add_argument(
        "--rate",
        type=rate,
        metavar="RATE",
        help="let time pass from the start, this many times as fast as it does, or as fast as possible (max); "
        "by default it passes while runs grant it",
    )
    add_keys_argument(parser)
    add_folders(
        parser,
        "--model-path",
        "look up models `name://path` in DIR/name first, where programs ask for them by name",
    )


def run(options: argparse.Namespace) -> int:
    """Run the command: the node takes the place of this process."""
    from seoro.bridges.door import node_name  # noqa: PLC0415 - Zenoh, for this command only
    from seoro.bridges.launch import check_installed  # noqa: PLC0415 - the same
    from seoro.bridges.session import is_secured  # noqa: PLC0415 - the same

    name, arguments = _beginning(options)
    check_installed(name)
    endpoint = options.connect or options.listen or DEFAULT_ENDPOINT
    if is_secured(endpoint):
        options.node = node_name(endpoint, options.node, name)
        arguments += ["--audit", str(node_file("simulators", options.node, endpoint, "audit.jsonl"))]
    for option in ("seed", "listen", "connect", "node", "rate"):
        if getattr(options, option) is not None:
            arguments += [f"--{option}", str(getattr(options, option))]
    arguments += ["--stop-file", str(node_file("simulators", options.node or name, endpoint, "stop.json"))]
    for folder in options.model_path:
        arguments += ["--model-path", str(folder)]
    os.execv(sys.executable, [sys.executable, "-m", "sim_nodes", name, *arguments])  # noqa: S606


def _beginning(options: argparse.Namespace) -> tuple[str, list[str]]:
    """The simulator, and how it is told what to begin at.

    Raises:
        InvalidUse: It is not said which, or what was said contradicts itself.
    """
    path = options.from_snapshot
    if path is None:
        if options.name is None:
            raise InvalidUse("it is not said which simulator", help="such as `seoro sim mujoco`")
        return options.name, ["--world", options.world or DEFAULT_WORLD]
    from seoro.bridges.snapshots import read_snapshot  # noqa: PLC0415 - the messages of simulators

    if options.world is not None:
        raise InvalidUse("a snapshot has its own world", help="leave out `--world`, or the snapshot")
    snapshot = read_snapshot(path)
    if options.name not in (None, snapshot.engine):
        raise InvalidUse(
            f"{path} was saved by {snapshot.engine}, and means nothing to {options.name}",
            help=f"leave out `{options.name}`: it goes on in the simulator that saved it",
        )
    return snapshot.engine, ["--from-snapshot", str(path)]

"""`seoro sim`: start a simulator node by hand."""

from __future__ import annotations

import argparse
import os
import sys

EXAMPLES = """examples:
  seoro sim mujoco --world maze
  seoro exec obstacle.osc --connect tcp/127.0.0.1:7450      (in another terminal)

It ends on Ctrl-C."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    parser.add_argument(
        "name", metavar="NAME", help="the simulator: mujoco, pybullet, or one that an installed package brings"
    )
    parser.add_argument(
        "--world", default="maze", metavar="WORLD", help="name or file of the world (default: maze)"
    )
    parser.add_argument("--seed", type=int, default=0, metavar="N", help="seed of all it draws (default: 0)")
    parser.add_argument(
        "--listen", metavar="ENDPOINT", help="Zenoh endpoint to listen on (default: tcp/127.0.0.1:7450)"
    )
    parser.add_argument(
        "--rate",
        metavar="RATE",
        help="let time pass from the start, this many times as fast as it does, or as fast as possible (max); "
        "by default it passes while runs grant it",
    )


def run(options: argparse.Namespace) -> int:
    """Run the command: the node takes the place of this process."""
    from seoro.bridges.launch import check_installed  # noqa: PLC0415 - Zenoh, for this command only

    check_installed(options.name)
    arguments = ["--world", options.world, "--seed", str(options.seed)]
    if options.listen is not None:
        arguments += ["--listen", options.listen]
    if options.rate is not None:
        arguments += ["--rate", options.rate]
    os.execv(sys.executable, [sys.executable, "-m", "sim_nodes", options.name, *arguments])  # noqa: S606

"""`python -m sim_nodes ENGINE`: start a simulator node; `python -m sim_nodes inspect MODEL`: describe a robot."""

from __future__ import annotations

import gc
import os
import sys

if __name__ == "__main__":
    gc.disable()  # until `main` starts: imports leave no garbage
    os.environ.setdefault("PYDANTIC_DISABLE_PLUGINS", "__all__")  # they are searched in all installed packages
    # Threads of numpy and scipy for large matrices, which nodes do not have, wait busily after their start.
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    sys.modules["ssl"] = None  # type: ignore[assignment]  # asyncio imports it where it is; nodes have no use for it

import argparse
import math
from collections.abc import Callable, Sequence
from functools import partial
from importlib.metadata import entry_points
from pathlib import Path

from seoro.bridges.models import ModelPath
from seoro.bridges.session import SessionError
from seoro.bridges.wire import SimulationState, node_command
from seoro.bridges.wire.keys import NAMESPACE
from seoro.bridges.wire.refusal import RequestRefused
from seoro.errors import UsageError
from seoro.text.logs import log_to_stderr
from sim_nodes import snapshots
from sim_nodes.memory import return_free, zeros_returned
from sim_nodes.node import NodeSettings, die_with_parent, end_on_signals, serve
from sim_nodes.physics import Engine
from sim_nodes.simulator import Simulator

DEFAULT_ENDPOINT = "tcp/127.0.0.1:7450"
INSPECT = "inspect"
INVALID = 2  # exit status for an invalid command line or an unusable argument


def _mujoco() -> Engine:
    from sim_nodes.mujoco.engine import MujocoEngine  # noqa: PLC0415

    return MujocoEngine()


def _pybullet() -> Engine:
    from sim_nodes.pybullet.engine import PybulletEngine  # noqa: PLC0415

    return PybulletEngine()


# Engines are optional dependencies, so each is imported on use.
ENGINES: dict[str, Callable[[], Engine]] = {"mujoco": _mujoco, "pybullet": _pybullet}
INSTALLED = "seoro.engines"  # entry point group of packages with other engines


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a node until it is stopped, or inspect a robot; returns the exit status."""
    gc.enable()
    given = sys.argv[1:] if arguments is None else list(arguments)
    if given[:1] == [INSPECT]:
        from sim_nodes.robots.inspection_text import main as inspect  # noqa: PLC0415 - for this command only

        return inspect(given[1:])
    options = _parser().parse_args(given)
    log_to_stderr("%(name)s: %(levelname)s: %(message)s")
    listen = None if options.connect else options.listen or DEFAULT_ENDPOINT
    node = options.node or options.engine
    settings = NodeSettings(node, options.namespace, listen, options.connect, options.stop_file, options.audit)
    end_on_signals()
    if options.die_with_parent:
        die_with_parent(options.folder)
    make = partial(_make, _engine(options.engine), options)
    try:
        node_command(settings.namespace, settings.node, "*")
        serve(settings, make, partial(_announce, settings, quiet=listen is None and options.die_with_parent))
    except KeyboardInterrupt:
        return 0
    except (SessionError, RequestRefused, UsageError, ValueError) as error:
        hint = error.help if isinstance(error, UsageError) else ""
        sys.stderr.write(f"error: {error}\n" + (f"  = help: {hint}\n" if hint else ""))
        return INVALID
    return 0


def _engine(name: str) -> Callable[[], Engine]:
    """Return the factory of an engine: built in, or an entry point `name = "module:Class"`."""
    return ENGINES.get(name) or next(iter(entry_points(group=INSTALLED, name=name))).load()


def _engine_name(text: str) -> str:
    """Check the name of an engine.

    Raises:
        argparse.ArgumentTypeError: The engine is unknown.
    """
    if text in ENGINES:  # reading the metadata of all installed packages takes long
        return text
    installed = entry_points(group=INSTALLED).names
    if text not in installed:
        names = ", ".join(sorted({*ENGINES, *installed}))
        raise argparse.ArgumentTypeError(f"unknown engine: {text!r} (engines: {names})")
    return text


def _make(engine: Callable[[], Engine], options: argparse.Namespace) -> Simulator:
    beginning = options.world if options.from_snapshot is None else snapshots.read(options.from_snapshot)
    with zeros_returned():  # of Bullet; all other threads wait yet
        physics = engine()
    simulator = Simulator(physics, beginning, options.seed, ModelPath(options.model_path))
    return_free()  # by compiled models
    if options.rate is not None:
        simulator.set_state(SimulationState.PLAYING, options.rate)
    return simulator


def _rate(text: str) -> float:
    """Parse a rate.

    Raises:
        ValueError: The rate is invalid; argparse reports it.
    """
    return math.inf if text == "max" else float(text)


def _announce(settings: NodeSettings, simulator: Simulator, *, quiet: bool) -> None:
    if quiet:
        return
    where = f"listens on {settings.listen}" if settings.listen else f"is connected to {settings.connect}"
    world = simulator.simulation.world.name
    since = f" at {simulator.time:.2f} s" if simulator.time > 0.0 else ""
    sys.stdout.write(f"{settings.node} {where} with the world {world}{since}; press Ctrl-C to stop\n")
    sys.stdout.flush()


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog="sim_nodes", description="Run a simulator node.")
    parser.add_argument("engine", type=_engine_name, help="mujoco, pybullet, or an installed engine")
    place = parser.add_mutually_exclusive_group()
    place.add_argument("--connect", metavar="ENDPOINT", help="connect to the Zenoh hub at ENDPOINT")
    place.add_argument(
        "--listen", metavar="ENDPOINT", help=f"run as hub and listen on ENDPOINT (default {DEFAULT_ENDPOINT})"
    )
    parser.add_argument("--namespace", default=NAMESPACE, help="namespace of the node (default %(default)s)")
    parser.add_argument("--node", help="node name (default: name of the engine)")
    parser.add_argument(
        "--audit", type=Path, metavar="FILE", help="append requests to this audit log (labs with keys only)"
    )
    beginning = parser.add_mutually_exclusive_group()
    beginning.add_argument("--world", default="maze", help="world name or file (default %(default)s)")
    beginning.add_argument("--from-snapshot", type=Path, metavar="FILE", help="continue from a snapshot")
    parser.add_argument("--seed", type=int, help="random seed (default 0, or the seed of the snapshot)")
    parser.add_argument(
        "--rate",
        type=_rate,
        metavar="RATE",
        help="start unpaused at this rate (1 = real time, max = as fast as possible)",
    )
    parser.add_argument(
        "--model-path",
        type=Path,
        action="append",
        default=[],
        metavar="DIR",
        help="search DIR/name for models with URIs `name://path` (repeatable)",
    )
    parser.add_argument(
        "--stop-file", type=Path, metavar="FILE", help="keep an emergency stop in FILE, also across restarts"
    )
    parser.add_argument("--die-with-parent", action="store_true", help="exit when stdin closes; ignore Ctrl-C")
    parser.add_argument(
        "--folder", metavar="DIR", help="with --die-with-parent: delete this folder if the parent is killed"
    )
    return parser


if __name__ == "__main__":
    del sys.modules["ssl"]  # others may import it
    gc.freeze()  # else each full collection would visit all modules
    sys.exit(main())

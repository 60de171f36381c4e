"""Options of a run: scenario, parameters, simulator, lab and ROS 2; for `seoro exec` and `seoro campaign run`."""

from __future__ import annotations

import argparse
import math
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Unpack

from seoro.bridges.addresses import ROS_ROUTER
from seoro.cli.arguments import add_option, domain, given_option, pose_rate, rate, seed
from seoro.embed.file_settings import FileSettings, settings_of_file
from seoro.embed.options import ROS_SIMULATOR, Lab, Leasing, OptionFields, Options, Ros, Simulator, options_from
from seoro.embed.runnable import Runnable
from seoro.errors import UsageError
from seoro.files.inputs import resolved
from seoro.files.world_names import WorldName
from seoro.robotics.tracks import POSE_RATE

DEFAULT_RATE = 1.0  # simulated seconds per second
_OPTION_NAMES = {"snapshot": "--from-snapshot", "lab": "--lab", "ros": "--ros", "timeout": "--timeout SECONDS"}


def add_run_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    add_option(parser, "--scenario NAME", "scenario to run, if the file has several")
    add_option(
        parser, "--set PATH=VALUE", "set a parameter to an expression, such as robot.goal.x=3m", repeatable=True
    )
    add_option(
        parser,
        "--params FILE",
        "YAML file with parameters: a mapping under the name of the scenario, numbers in SI base units",
    )
    add_option(
        parser,
        "--constrain EXPRESSION",
        "constrain parameters by a boolean expression, such as 'pace in [1mps..2mps]'",
        repeatable=True,
    )
    add_option(parser, "--seed N", "random seed (default: random)", type=seed)
    add_option(
        parser,
        "--clock",
        "clock of the run (default: real; sim with a simulator)",
        choices=("real", "virtual", "sim"),
    )
    _add_simulator_arguments(parser)
    _add_ros_arguments(parser)
    add_option(
        parser,
        "--poses HZ",
        f"samples of poses in the trace, per second of the run's clock; 0 for none (default: {POSE_RATE:g})",
        type=pose_rate,
    )
    add_option(
        parser,
        "--scans HZ",
        "scans of each planar lidar of a simulator in the trace, per second; at most those of poses (default: 0)",
        type=pose_rate,
    )
    add_option(parser, "--timeout SECONDS", "end the run with an error after this wall time (default: 3600)")


def _add_simulator_arguments(parser: argparse.ArgumentParser) -> None:
    place = parser.add_mutually_exclusive_group()
    add_option(
        place,
        "--sim NAME",
        "start this simulator for the run: mujoco or pybullet; ros uses the running simulator of the ROS 2 "
        "system (`--ros`)",
    )
    add_option(place, "--lab FILE", "lab file that assigns robots or simulators to actors")
    add_option(place, "--connect ENDPOINT", "use the simulator node at this Zenoh endpoint")
    add_option(parser, "--world WORLD", "name or file of the world (default: that of the simulator)")
    add_option(parser, "--from-snapshot FILE", "start from a saved state, with its world and simulator")
    add_option(parser, "--rate R", "simulated seconds per second, or max (default: 1)", type=rate)
    add_option(
        parser,
        "--model-path DIR",
        "folder to search first for models `name://path`, as DIR/name/path",
        repeatable=True,
    )


def _add_ros_arguments(parser: argparse.ArgumentParser) -> None:
    add_option(
        parser,
        "--ros ENDPOINT",
        "connect to a ROS 2 system over its Zenoh router or bridge, such as tcp/192.168.0.7:7447?domain=3 "
        f"(default: {ROS_ROUTER}, domain ROS_DOMAIN_ID or 0)",
        nargs="?",
        const=ROS_ROUTER,
    )
    add_option(
        parser,
        "--ros-interfaces DIR",
        "folder of packages with more definitions of messages, services and actions",
        repeatable=True,
    )
    add_option(
        parser,
        "--no-ros-state",
        "do not publish the state of the run on /seoro/behaviors and /seoro/markers, nor serve /seoro/stop",
    )


def use_file_settings(options: argparse.Namespace, scenario: Runnable, *, repeats: bool = False) -> FileSettings:
    """Fill in options from the directives of a scenario file, and print notes about ignored directives.

    Args:
        options: Parsed command line; its options take precedence.
        scenario: The checked file.
        repeats: Whether the command runs the scenario once per seed.

    Raises:
        InvalidScenario, UsageError: As `settings_of_file`.
    """
    simulator = Simulator(options.sim, options.connect, options.world, snapshot=options.from_snapshot)
    given = Options(
        name=options.scenario,
        seed=options.seed,
        overrides=overrides_of(options.set),
        parameters=options.params,
        clock=options.clock,
        simulator=simulator if _has_simulator(options) else None,
        ros=options.ros and Ros(options.ros),
        lab=options.lab and Lab(options.lab),
        timeout=options.timeout,
    )
    found = settings_of_file(
        scenario,
        given,
        _OPTION_NAMES | {"clock": f"--clock {options.clock}"},
        world=options.world,
        repeats=repeats,
    )
    options.set = [*(f"{path}={value}" for path, value in found.overrides.items()), *options.set]
    options.constrain = [*found.constraints, *options.constrain]
    options.sim, options.world, options.seed = found.simulator, found.world, found.seed
    options.lab = found.lab if options.lab is None else options.lab
    options.rate = found.rate if options.rate is None else options.rate
    options.model_path = [*options.model_path, *found.model_path]
    for note in found.notes:
        print(f"note: {note}", file=sys.stderr)
    return found


def inputs_of(options: argparse.Namespace, scenario: Runnable) -> list[Path]:
    """Return the files that a run reads: the scenario, its imports, and files named by options."""
    sources = [file.path for file in scenario.files]
    named = [options.params, options.lab, options.from_snapshot, options.world]
    return [path for path in sources if path is not None] + [Path(name) for name in named if name is not None]


def settings_of(options: argparse.Namespace, **more: Unpack[OptionFields]) -> Options:
    """Convert the command line into the options of a run.

    Args:
        options: Options of the command line.
        more: Other fields of `Options`.

    Raises:
        UsageError: The options contradict each other.
    """
    return options_from(
        {
            "name": options.scenario,
            "seed": options.seed,
            "overrides": overrides_of(options.set),
            "parameters": options.params,
            "constraints": options.constrain,
            "clock": options.clock,
            "simulator": simulator_of(options),
            "ros": ros_of(options),
            "lab": lab_of(options),
            "poses": options.poses,
            "scans": options.scans or 0.0,
            **more,
        }
    )


def ros_of(options: argparse.Namespace) -> Ros | None:
    """Return the ROS 2 system of the options, if any."""
    if options.ros is None:
        for option, is_given in (
            ("--ros-interfaces", options.ros_interfaces),
            ("--no-ros-state", options.no_ros_state),
        ):
            if is_given:
                raise UsageError(f"`{option}` needs a ROS 2 system", help="add `--ros`")
        return None
    endpoint, _, query = options.ros.partition("?")
    given = dict(pair.partition("=")[::2] for pair in query.split("&") if pair)
    text = given.pop("domain", os.environ.get("ROS_DOMAIN_ID") or "0")
    dialect = given.pop("dialect", None)
    if given or not endpoint:
        known = "tcp/192.168.0.7:7447?domain=3&dialect=rmw_zenoh"
        raise UsageError(f"invalid `--ros {options.ros}`: expected ENDPOINT?domain=N", help=f"for example {known}")
    try:
        number_of_domain = domain(text)
    except argparse.ArgumentTypeError as error:
        raise UsageError(str(error)) from None
    return Ros(endpoint, number_of_domain, dialect, options.ros_interfaces, state=not options.no_ros_state)


def lab_of(options: argparse.Namespace) -> Lab | None:
    """Return the lab of the options, if any."""
    if options.lab is None:
        return None
    if given := given_option(options, "world", "from_snapshot"):
        raise UsageError(f"`{given}` contradicts `--lab`", help="name the world in the lab file")
    return Lab(options.lab, DEFAULT_RATE if options.rate is None else options.rate, options.model_path)


def simulator_of(options: argparse.Namespace) -> Simulator | None:
    """Return the simulator of the options, if any."""
    if options.lab is not None:
        return None
    if not _has_simulator(options):
        if given := given_option(options, "world", "rate", "model_path"):
            raise UsageError(f"`{given}` needs a simulator", help="add `--sim mujoco`")
        return None
    return Simulator(
        name=options.sim,
        endpoint=options.connect,
        world=_world(options.world, options.sim),
        rate=DEFAULT_RATE if options.rate is None else options.rate,
        model_path=options.model_path,
        snapshot=options.from_snapshot,
    )


def _has_simulator(options: argparse.Namespace) -> bool:
    return any(each is not None for each in (options.sim, options.connect, options.from_snapshot))


def _world(world: str | None, simulator: str | None) -> str | None:
    """Return the world for the simulator, which may run in another folder: files become absolute paths."""
    if world is None:
        return None
    # Simulators of ROS 2 systems have their own names of worlds, which may look like files.
    if simulator == ROS_SIMULATOR:
        return str(resolved(Path(world))) if Path(world).is_file() else world
    name = WorldName.parse(world)
    path = Path(name.world)
    is_file = name.is_file or (path.suffix != "" and path.is_file())
    return str(name.replaced(str(resolved(path)))) if is_file else world


def overrides_of(settings: Sequence[str]) -> dict[str, str]:
    """Parse the arguments of `--set` into expressions by path."""
    overrides = {}
    for setting in settings:
        path, equals, value = setting.partition("=")
        if not equals or not path.strip():
            raise UsageError(
                f"invalid `--set {setting}`: expected PATH=VALUE", help="for example `--set goal.x=3m`"
            )
        overrides[path.strip()] = value.strip()
    return overrides


def add_lease_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare the options."""
    group = parser.add_argument_group("shared robots")
    waiting = group.add_mutually_exclusive_group()
    add_option(waiting, "--when-free", "wait for busy robots, and for nodes that are not up yet")
    add_option(waiting, "--wait SECONDS", "wait for busy robots at most this long (default: do not wait)")
    add_option(group, "--lease ID", "use the robots of this lease (`seoro lab lease`)")


def leasing_of(options: argparse.Namespace, on_wait: Callable[[str], object] | None = None) -> Leasing:
    """Return the leasing that the options ask for.

    Args:
        options: Options of the command line.
        on_wait: Called with the users of busy robots, while the run waits.
    """
    # On an executor, the priority also orders its queue.
    given = given_option(options, "when_free", "wait", "lease", *(("priority",) if options.on is None else ()))
    if given and options.lab is None and options.connect is None:
        raise UsageError(
            f"`{given}` needs shared robots, and the run has none",
            help="add `--lab` or `--connect`",
        )
    wait = math.inf if options.when_free else options.wait
    return Leasing(wait=wait, priority=options.priority or 0, lease=options.lease or "", on_wait=on_wait)

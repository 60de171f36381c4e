"""The options that say what is run, and where: those of `seoro exec`, and of what runs it again and again."""

from __future__ import annotations

import argparse
import os
import sys
from collections.abc import Sequence
from pathlib import Path

from seoro.bridges.ros2.addresses import ROUTER
from seoro.cli.arguments import add_folders, domain, positive, rate, seed
from seoro.embed.file_settings import (
    CLOCK,
    ENDPOINT,
    LAB,
    ROS,
    SNAPSHOT,
    FileSettings,
    Given,
    place_of,
    settings_of_file,
)
from seoro.embed.options import OF_ROS, Lab, Options, Ros, Simulator
from seoro.embed.scenarios import Scenario
from seoro.errors import InvalidUse
from seoro.input_files import resolved

DEFAULT_RATE = 1.0  # simulated seconds per second


def add_run_arguments(parser: argparse.ArgumentParser) -> None:
    """Declare them."""
    parser.add_argument("--scenario", metavar="NAME", help="the scenario to run, if the file has several")
    parser.add_argument(
        "--set",
        metavar="PATH=VALUE",
        action="append",
        default=[],
        help="give a parameter, of the scenario or of what it invokes, a value, an expression of the language: "
        "--set robot.goal.x=3m, --set patrol.speed=1mps (repeatable)",
    )
    parser.add_argument(
        "--params",
        type=Path,
        metavar="FILE",
        help="values of parameters in YAML: a mapping under the scenario's name, numbers in SI base units",
    )
    parser.add_argument("--seed", type=seed, metavar="N", help="seed of everything that is drawn (default: drawn)")
    parser.add_argument(
        "--clock", choices=("real", "virtual", "sim"), help="the run's clock (default: real; sim with a simulator)"
    )
    _add_simulator_arguments(parser)
    _add_ros_arguments(parser)
    parser.add_argument(
        "--timeout",
        type=positive,
        metavar="SECONDS",
        help="end the run as an error after this wall time (default: 3600)",
    )


def _add_simulator_arguments(parser: argparse.ArgumentParser) -> None:
    place = parser.add_mutually_exclusive_group()
    place.add_argument(
        "--sim",
        metavar="NAME",
        help="start this simulator for the run, and stop it after: mujoco or pybullet; ros is the simulator that "
        "runs in the ROS 2 system of `--ros`",
    )
    place.add_argument(
        "--lab", type=Path, metavar="FILE", help="a lab file says which simulator or robot serves which actor"
    )
    place.add_argument("--connect", metavar="ENDPOINT", help="use the simulator node that runs at this endpoint")
    parser.add_argument(
        "--world", metavar="WORLD", help="name or file of the simulator's world (default: its own)"
    )
    parser.add_argument(
        "--from-snapshot",
        type=Path,
        metavar="FILE",
        help="begin at the state that a run has saved, with its world, in the simulator that saved it",
    )
    parser.add_argument("--rate", type=rate, metavar="R", help="simulated seconds per second, or max (default: 1)")
    add_folders(parser, "--model-path", "look up models `name://path` in DIR/name first")


def _add_ros_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "--ros",
        nargs="?",
        const=ROUTER,
        metavar="ENDPOINT",
        help="reach the ROS 2 system behind this Zenoh router or bridge, such as tcp/192.168.0.7:7447?domain=3 "
        f"(without ENDPOINT: {ROUTER}; domain: that of ROS_DOMAIN_ID, else 0; dialect=rmw_zenoh or ros2dds)",
    )
    add_folders(
        parser, "--ros-interfaces", "take definitions of messages, services and actions from the packages in DIR"
    )


def use_file_settings(options: argparse.Namespace, scenario: Scenario, *, repeats: bool = False) -> FileSettings:
    """Fill in the options that a scenario file gives by its directives, and print notes about the others.

    Args:
        options: The parsed command line; options that are given stay as they are.
        scenario: The checked file.
        repeats: Whether the command runs the scenario with every seed.

    Raises:
        InvalidScenario, InvalidUse: As `settings_of_file`.
    """
    places = {
        SNAPSHOT: (options.from_snapshot, "--from-snapshot"),
        ENDPOINT: (options.connect, "--connect"),
        LAB: (options.lab, "--lab"),
        ROS: (options.ros, "--ros"),
        CLOCK: (options.clock, f"--clock {options.clock}"),
    }
    given = Given(
        simulator=options.sim,
        place=place_of(places, has_simulator=options.sim is not None),
        world=options.world,
        seed=options.seed,
        timeout=options.timeout,
        timeout_option="--timeout SECONDS",
        parameters=None if options.params is not None else overrides_of(options.set),
    )
    found = settings_of_file(scenario.checked, options.scenario, given, repeats=repeats)
    options.sim, options.world, options.seed = found.simulator, found.world, found.seed
    for note in found.notes:
        print(f"note: {note}", file=sys.stderr)
    return found


def inputs_of(options: argparse.Namespace, scenario: Scenario) -> list[Path]:
    """Return the files that a run reads: the scenario with its imports, and those that options name."""
    sources = [module.file.path for module in scenario.checked.sources.modules]
    named = [options.params, options.lab, options.from_snapshot, options.world]
    return [path for path in sources if path is not None] + [Path(name) for name in named if name is not None]


def settings_of(options: argparse.Namespace) -> Options:
    """How the options ask for a scenario to be run.

    Raises:
        InvalidUse: They do not go together.
    """
    return Options(
        name=options.scenario,
        seed=options.seed,
        overrides=overrides_of(options.set),
        parameters=options.params,
        clock=options.clock,
        simulator=simulator_of(options),
        ros=ros_of(options),
        lab=lab_of(options),
    )


def ros_of(options: argparse.Namespace) -> Ros | None:
    """The ROS 2 system that the options ask for, if they do."""
    if options.ros is None:
        if options.ros_interfaces:
            raise InvalidUse("`--ros-interfaces` is for a ROS 2 system, and there is none", help="add `--ros`")
        return None
    endpoint, _, query = options.ros.partition("?")
    given = dict(pair.partition("=")[::2] for pair in query.split("&") if pair)
    text = given.pop("domain", os.environ.get("ROS_DOMAIN_ID") or "0")
    dialect = given.pop("dialect", None)
    if given or not endpoint:
        known = "tcp/192.168.0.7:7447?domain=3&dialect=rmw_zenoh"
        raise InvalidUse(f"`--ros {options.ros}` is not of the form ENDPOINT?domain=N", help=f"such as {known}")
    try:
        number_of_domain = domain(text)
    except argparse.ArgumentTypeError as error:
        raise InvalidUse(str(error)) from None
    return Ros(endpoint, number_of_domain, dialect, options.ros_interfaces)


def lab_of(options: argparse.Namespace) -> Lab | None:
    """The lab that the options name, if they do."""
    if options.lab is None:
        return None
    given = [name for name in ("world", "from_snapshot") if getattr(options, name) is not None]
    if given:
        raise InvalidUse(
            f"`--{given[0].replace('_', '-')}` does not go with `--lab`", help="the lab file names the world"
        )
    return Lab(options.lab, DEFAULT_RATE if options.rate is None else options.rate, options.model_path)


def simulator_of(options: argparse.Namespace) -> Simulator | None:
    """The simulator that the options ask for, if they do."""
    if options.lab is not None:
        return None
    if options.sim is None and options.connect is None and options.from_snapshot is None:
        theirs = {"--world": options.world, "--rate": options.rate, "--model-path": options.model_path or None}
        given = [name for name, value in theirs.items() if value is not None]
        if given:
            raise InvalidUse(f"`{given[0]}` is a simulator's, and there is none", help="add `--sim mujoco`")
        return None
    return Simulator(
        name=options.sim,
        endpoint=options.connect,
        world=_world(options.world, options.sim),
        rate=DEFAULT_RATE if options.rate is None else options.rate,
        model_path=options.model_path,
        snapshot=options.from_snapshot,
    )


def _world(world: str | None, simulator: str | None) -> str | None:
    """The world as the simulator is to be told, which may run in another folder."""
    if world is None:
        return None
    # What simulators of ROS 2 systems call their worlds is theirs, unless it is a file that is here.
    path = Path(world)
    is_file = (path.suffix != "" or simulator == OF_ROS) and path.is_file()
    is_named_so = simulator != OF_ROS and path.suffix in {".yaml", ".yml"}
    return str(resolved(path)) if is_file or is_named_so else world


def overrides_of(settings: Sequence[str]) -> dict[str, str]:
    """What `--set` gives, by path."""
    overrides = {}
    for setting in settings:
        path, equals, value = setting.partition("=")
        if not equals or not path.strip():
            raise InvalidUse(f"`--set {setting}` is not of the form PATH=VALUE", help="such as `--set goal.x=3m`")
        overrides[path.strip()] = value.strip()
    return overrides

"""How to run a scenario: what programs say by keyword arguments, and the command line by options."""

from __future__ import annotations

import math
import os
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from typing import Any, Literal, TypedDict

from seoro.embed.arguments import (
    AnyPath,
    instance_of,
    optional,
    to_flag,
    to_function,
    to_limit,
    to_number,
    to_overrides,
    to_path,
    to_paths,
    to_rate,
    to_text,
    to_wait,
    to_whole,
    wrong_type,
)
from seoro.embed.scenarios import Scenario
from seoro.errors import InvalidUse
from seoro.lang.diagnostics import near
from seoro.lang.plan import Plan
from seoro.located import Locate, as_named
from seoro.runtime.contracts import Observer

OF_ROS = "ros"  # names the simulator of a ROS 2 system

ClockName = Literal["real", "virtual", "sim"]


@dataclass(frozen=True, init=False)
class Simulator:
    """The simulator of a run.

    Args:
        name: Of the simulator to start for the run, such as `mujoco`; `ros` for the one that runs in the ROS 2
            system of the run. None to connect to one that is running.
        endpoint: Zenoh endpoint of the one that is running, such as `tcp/127.0.0.1:7450`.
        world: Name or file of the world; None for the simulator's own choice.
        rate: Simulated seconds per second; infinite for as fast as possible.
        model_path: Folders in which models are looked up first.
        snapshot: File with the state to begin at, which a run left with `-o`; it has its own world, and its own
            simulator if none is named.
    """

    name: str | None = None
    endpoint: str | None = None
    world: str | None = None
    rate: float = math.inf
    model_path: Sequence[Path] = ()
    snapshot: Path | None = None

    def __init__(
        self,
        name: str | None = None,
        endpoint: str | None = None,
        world: AnyPath | None = None,
        rate: float | Literal["max"] = math.inf,
        model_path: Iterable[AnyPath] = (),
        snapshot: AnyPath | None = None,
    ) -> None:
        _set(
            self,
            name=optional(to_text, "name", name),
            endpoint=optional(to_text, "endpoint", endpoint),
            # A text is kept as it is: simulators of others have worlds with URIs, which are no paths.
            world=world if world is None or isinstance(world, str) else os.fspath(to_path("world", world)),
            rate=to_rate("rate", rate),
            model_path=to_paths("model_path", model_path),
            snapshot=optional(to_path, "snapshot", snapshot),
        )


@dataclass(frozen=True, init=False)
class Ros:
    """The ROS 2 system of a run.

    Args:
        endpoint: Zenoh endpoint of the router that the robot's nodes use, or of its bridge for DDS, such as
            `tcp/192.168.0.7:7447`.
        domain: ROS_DOMAIN_ID of the robot's nodes.
        dialect: `rmw_zenoh` or `ros2dds`; None to find that out, for which something of the system has to be seen.
        interfaces: Folders with definitions of messages, services and actions that seoro does not bring.
    """

    endpoint: str
    domain: int = 0
    dialect: str | None = None
    interfaces: Sequence[Path] = ()

    def __init__(
        self, endpoint: str, domain: int = 0, dialect: str | None = None, interfaces: Iterable[AnyPath] = ()
    ) -> None:
        _set(
            self,
            endpoint=to_text("endpoint", endpoint),
            domain=to_whole("domain", domain),
            dialect=optional(to_text, "dialect", dialect),
            interfaces=to_paths("interfaces", interfaces),
        )


@dataclass(frozen=True, init=False)
class Lab:
    """A lab file: which simulator or robot serves which actor.

    Args:
        file: The file.
        rate: Simulated seconds per second of its simulator; None for 1 beside robots, which move in real time, and
            as fast as possible otherwise.
        model_path: Folders in which models are looked up first.
    """

    file: Path
    rate: float | None = None
    model_path: Sequence[Path] = ()

    def __init__(
        self, file: AnyPath, rate: float | Literal["max"] | None = None, model_path: Iterable[AnyPath] = ()
    ) -> None:
        _set(
            self,
            file=to_path("file", file),
            rate=optional(to_rate, "rate", rate),
            model_path=to_paths("model_path", model_path),
        )


@dataclass(frozen=True)
class Leasing:
    """How a run claims robots that others may have.

    Args:
        wait: For how long it waits for them [s], which may be infinite; None to fail at once.
        priority: Of its place in line; higher ones come first.
        lease: Id of a lease by hand under which it has them.
        say: Called with who has them, while it waits.
        turn: Awaited when it has those that it has waited for, before it goes on.
    """

    wait: float | None = None
    priority: int = 0
    lease: str = ""
    say: Callable[[str], object] | None = None
    turn: Callable[[], Awaitable[object]] | None = None

    def __post_init__(self) -> None:
        optional(to_wait, "wait", self.wait)
        to_whole("priority", self.priority)
        to_text("lease", self.lease)
        optional(to_function, "say", self.say)
        optional(to_function, "turn", self.turn)


def _set(instance: object, **values: object) -> None:
    """Set the fields of a frozen instance."""
    for name, value in values.items():
        object.__setattr__(instance, name, value)


@dataclass(frozen=True)
class Options:
    """How to run a scenario.

    Args:
        name: Of the scenario to run, if the file has several.
        seed: Of everything that is drawn; drawn itself if it is None.
        overrides: Values of parameters, by path, as expressions of the language: `{"robot.goal.x": "3m"}`.
        parameters: A parameter file (see `seoro.parameters`); `overrides` go before what it says.
        clock: `real` if it is not given, `sim` if there is a simulator.
        simulator: To start or to connect to.
        ros: To reach.
        lab: The simulator and the robots of the run, in the place of `simulator`.
        leasing: How it claims robots that others may have.
        observers: Called with every record of the trace.
        output_directory: Where the results of the run go; methods of libraries may ask for it.
        keep_trace: Whether to hold the whole trace in memory, so that `Run.trace` can be read at any time.
        grace: Time for the clean-up of a cancelled action [s].
        timeout: Limit of wall time, after which the run ends as an error [s], which may be infinite; None for that
            of the scenario file (`# seoro: timeout`), or one hour.
        vet: Called with the plan before anything is started; what it raises comes out of `start`.
        load: Loads the scenarios that a lab file names; `seoro.load` if it is not given.
        locate: Gives the places of files that are named by absolute paths.
    """

    name: str | None = None
    seed: int | None = None
    overrides: Mapping[str, str] = field(default_factory=dict)
    parameters: Path | None = None
    clock: ClockName | None = None
    simulator: Simulator | None = None
    ros: Ros | None = None
    lab: Lab | None = None
    leasing: Leasing = Leasing()
    observers: Sequence[Observer] = ()
    output_directory: Path | None = None
    keep_trace: bool = False
    grace: float = 5.0
    timeout: float | None = None
    vet: Callable[[Plan], object] | None = None
    load: Callable[[Path], Scenario] | None = None
    locate: Locate = as_named


class OptionFields(TypedDict, total=False):
    """The fields of `Options`, as keyword arguments; `options_from` checks and converts them."""

    name: str | None
    seed: int | None
    overrides: Mapping[str, object]
    parameters: AnyPath | None
    clock: ClockName | None
    simulator: Simulator | None
    ros: Ros | None
    lab: Lab | None
    leasing: Leasing
    observers: Sequence[Observer]
    output_directory: AnyPath | None
    keep_trace: bool
    grace: float
    timeout: float | None
    vet: Callable[[Plan], object] | None
    load: Callable[[Path], Scenario] | None
    locate: Locate


_CONVERSIONS: Mapping[str, Callable[[str, object], Any]] = {
    "name": partial(optional, to_text),
    "seed": partial(optional, to_whole),
    "overrides": to_overrides,
    "parameters": partial(optional, to_path),
    "clock": partial(optional, to_text),
    "simulator": partial(optional, instance_of(Simulator, 'seoro.Simulator(name="mujoco")')),
    "ros": partial(optional, instance_of(Ros, 'seoro.Ros("tcp/192.168.0.7:7447")')),
    "lab": partial(optional, instance_of(Lab, 'seoro.Lab("hall.yaml")')),
    "leasing": instance_of(Leasing, "seoro.Leasing(wait=60.0)"),
    "output_directory": partial(optional, to_path),
    "keep_trace": to_flag,
    "grace": to_number,
    "timeout": partial(optional, to_limit),
}


def options_from(fields: OptionFields) -> Options:
    """Make the options of a run from keyword arguments of a program.

    Raises:
        InvalidUse: An argument is unknown or of a wrong type; the error says what was expected.
    """
    known = OptionFields.__annotations__
    for name in fields:
        if name not in known:
            raise InvalidUse(f"unknown option `{name}`", help=near(name, known) or f"options: {', '.join(known)}")
    return Options(**{name: _CONVERSIONS.get(name, _as_given)(name, value) for name, value in fields.items()})


def _as_given(name: str, value: object) -> Any:
    """Functions and observers, which are called as they are."""
    if name == "observers" and not (
        isinstance(value, Sequence) and all(hasattr(each, "record") for each in value)
    ):
        raise wrong_type(name, value, "a list of objects with a method `record`")
    if name in ("vet", "load", "locate"):
        optional(to_function, name, value)
    return value

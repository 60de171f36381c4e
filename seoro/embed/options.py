"""Options of a run, from keyword arguments of programs or from the command line."""

from __future__ import annotations

import math
import os
from collections.abc import Awaitable, Callable, Iterable, Mapping, Sequence
from dataclasses import field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal, TypedDict

from seoro.embed.arguments import (
    AnyPath,
    instance_of,
    list_of,
    optional,
    to_flag,
    to_function,
    to_limit,
    to_number,
    to_overrides,
    to_path,
    to_paths,
    to_pose_rate,
    to_rate,
    to_text,
    to_texts,
    to_wait,
    to_whole,
    wrong_type,
)
from seoro.errors import UsageError
from seoro.files.path_mapping import Locate, unchanged_path
from seoro.lang.diagnostics import near
from seoro.lang.frozen import Value
from seoro.lang.plan import Plan
from seoro.robotics.tracks import POSE_RATE

if TYPE_CHECKING:
    from seoro.embed.scenarios import Scenario
    from seoro.runtime.contracts.observers import Observer
    from seoro.runtime.debug.debugger import Debugger

SEED_BITS = 32  # of random seeds
ROS_SIMULATOR = "ros"  # name for the simulator of the ROS 2 system

ClockName = Literal["real", "virtual", "sim"]


class Simulator(Value):
    """Simulator of a run.

    Args:
        name: Name of the simulator to start, such as `mujoco`; `ros` for the running one in the ROS 2 system of
            the run. None to connect to a running simulator node.
        endpoint: Zenoh endpoint of a running simulator node, such as `tcp/127.0.0.1:7450`.
        world: Name or file of the world; None for the default of the simulator.
        rate: Simulated seconds per second; infinite for as fast as possible.
        model_path: Folders that are searched first for models.
        snapshot: File with a saved state to start from; it determines the world, and the simulator if none is
            named.
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
            # A text is kept as it is: worlds of foreign simulators may be URIs.
            world=world if world is None or isinstance(world, str) else os.fspath(to_path("world", world)),
            rate=to_rate("rate", rate),
            model_path=to_paths("model_path", model_path),
            snapshot=optional(to_path, "snapshot", snapshot),
        )


class Ros(Value):
    """ROS 2 system of a run.

    Args:
        endpoint: Zenoh endpoint of the router of its nodes, or of its bridge for DDS, such as
            `tcp/192.168.0.7:7447`.
        domain: ROS_DOMAIN_ID of its nodes.
        dialect: `rmw_zenoh` or `ros2dds`; None to detect it, which needs a running node.
        interfaces: Folders with more definitions of messages, services and actions.
        state: Whether the run publishes its state on topics `/seoro/*`, and serves `/seoro/stop`.
    """

    endpoint: str
    domain: int = 0
    dialect: str | None = None
    interfaces: Sequence[Path] = ()
    state: bool = True

    def __init__(
        self,
        endpoint: str,
        domain: int = 0,
        dialect: str | None = None,
        interfaces: Iterable[AnyPath] = (),
        *,
        state: bool = True,
    ) -> None:
        _set(
            self,
            endpoint=to_text("endpoint", endpoint),
            domain=to_whole("domain", domain),
            dialect=optional(to_text, "dialect", dialect),
            interfaces=to_paths("interfaces", interfaces),
            state=to_flag("state", state),
        )


class Lab(Value):
    """Lab file, which assigns robots or simulators to actors.

    Args:
        file: The file.
        rate: Simulated seconds per second of its simulator; None for 1 in a lab with real robots, and as fast as
            possible otherwise.
        model_path: Folders that are searched first for models.
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


class Leasing(Value):
    """Leasing of shared robots for a run.

    Args:
        wait: Time limit for waiting for busy robots [s], which may be infinite; None to fail at once.
        priority: Priority in the wait queue; higher first.
        lease: Id of an existing lease to use.
        on_wait: Called with the users of busy robots, while the run waits.
        on_acquired: Awaited when the run has acquired robots after a wait, before it starts.
    """

    wait: float | None = None
    priority: int = 0
    lease: str = ""
    on_wait: Callable[[str], object] | None = None
    on_acquired: Callable[[], Awaitable[object]] | None = None

    def __init__(
        self,
        wait: float | None = None,
        priority: int = 0,
        lease: str = "",
        on_wait: Callable[[str], object] | None = None,
        on_acquired: Callable[[], Awaitable[object]] | None = None,
    ) -> None:
        _set(
            self,
            wait=optional(to_wait, "wait", wait),
            priority=to_whole("priority", priority),
            lease=to_text("lease", lease),
            on_wait=optional(to_function, "on_wait", on_wait),
            on_acquired=optional(to_function, "on_acquired", on_acquired),
        )


def _set(instance: object, **values: object) -> None:
    """Set the fields of a frozen instance."""
    for name, value in values.items():
        object.__setattr__(instance, name, value)


class Options(Value):
    """Options of a run.

    Args:
        name: Name of the scenario, if the file has several.
        seed: Random seed; None for a random one.
        overrides: Values of parameters, by path, as expressions of the language: `{"robot.goal.x": "3m"}`.
        parameters: Parameter file (see `seoro.embed.parameter_files`); `overrides` take precedence.
        constraints: Constraints on parameters, as boolean expressions of the language: `robot.goal.x in [1m..2m]`.
        clock: Name of the clock; by default `real`, or `sim` with a simulator.
        simulator: Simulator to start or to connect to.
        ros: ROS 2 system to connect to.
        bag: Recorded ROS 2 bag that the run observes, at the times of the bag, instead of a system.
        lab: Lab of the run, instead of `simulator`.
        leasing: Leasing of shared robots.
        observers: Observers of the trace.
        output_directory: Folder for the results of the run; available to methods of libraries.
        keep_trace: Whether to keep the whole trace in memory, so that `Run.trace` can be read at any time.
        poses: Samples of poses in the trace [1/s], at most 50; 0 for none. None for 10 if the trace is kept, by
            `observers` or `keep_trace`.
        scans: Scans of each planar lidar of a simulator in the trace [1/s], at most the rate of poses; 0 for none.
        grace: Time limit for the clean-up of a cancelled action [s].
        timeout: Limit of wall time after which the run ends with an error [s]; may be infinite. None for that
            of the scenario file (`# seoro: timeout`), or one hour.
        external: Names of events that the application may emit with `Run.emit`. A run on the virtual clock
            waits for them when nothing else is due.
        replay: Records of an earlier run, whose external events are emitted again at their times, without an
            application. `seoro.replay` also takes all other options from the records.
        vet: Called with the plan before anything starts; `start` propagates its exceptions.
        load: Function that loads the scenarios of a lab file; by default `seoro.load`.
        locate: Function that maps absolute paths of files.
        debugger: Debugger of the run, which needs a virtual or simulated clock.
    """

    name: str | None = None
    seed: int | None = None
    overrides: Mapping[str, str] = field(default_factory=dict)
    parameters: Path | None = None
    constraints: Sequence[str] = ()
    clock: ClockName | None = None
    simulator: Simulator | None = None
    ros: Ros | None = None
    bag: Path | None = None
    lab: Lab | None = None
    leasing: Leasing = Leasing()
    observers: Sequence[Observer] = ()
    output_directory: Path | None = None
    keep_trace: bool = False
    poses: float | None = None
    scans: float = 0.0
    grace: float = 5.0
    timeout: float | None = None
    external: Sequence[str] = ()
    replay: Sequence[Mapping[str, Any]] | None = None
    vet: Callable[[Plan], object] | None = None
    load: Callable[[Path], Scenario] | None = None
    locate: Locate = unchanged_path
    debugger: Debugger | None = None


def pose_rate(options: Options) -> float:
    """Return the rate of poses in the trace of a run [1/s]; 0 for none."""
    if options.poses is not None:
        return options.poses
    return POSE_RATE if options.observers or options.keep_trace else 0.0


class OptionFields(TypedDict, total=False):
    """The fields of `Options`, as keyword arguments; `options_from` checks and converts them."""

    name: str | None
    seed: int | None
    overrides: Mapping[str, object]
    parameters: AnyPath | None
    constraints: Sequence[str]
    clock: ClockName | None
    simulator: Simulator | None
    ros: Ros | None
    bag: AnyPath | None
    lab: Lab | None
    leasing: Leasing
    observers: Sequence[Observer]
    output_directory: AnyPath | None
    keep_trace: bool
    poses: float | None
    scans: float
    grace: float
    timeout: float | None
    external: Sequence[str]
    replay: Sequence[Mapping[str, Any]] | None
    vet: Callable[[Plan], object] | None
    load: Callable[[Path], Scenario] | None
    locate: Locate
    debugger: Debugger | None


def options_from(fields: OptionFields) -> Options:
    """Make the options of a run from keyword arguments of a program.

    Raises:
        UsageError: An argument is unknown or of a wrong type; the error states the expected one.
    """
    defaults = Options.__field_defaults__
    for name in fields:
        if name not in _CONVERSIONS:
            known = near(name, _CONVERSIONS) or f"options: {', '.join(_CONVERSIONS)}"
            raise UsageError(f"unknown option `{name}`", help=known)
    given: dict[str, Any] = {
        name: None if value is None and defaults[name] is None else _CONVERSIONS[name](name, value)
        for name, value in fields.items()
    }
    return Options(**given)


def _to_observer(name: str, value: object) -> Any:
    if not hasattr(value, "record"):
        raise wrong_type(name, value, "an object with a method `record`")
    return value


def _to_debugger(name: str, value: object) -> Any:
    from seoro.runtime.debug.debugger import Debugger  # noqa: PLC0415 - for runs that are debugged

    return instance_of(Debugger, "a seoro.Debugger", "seoro.Debugger()")(name, value)


def _instance(kind: type, example: str) -> Callable[[str, object], Any]:
    return instance_of(kind, f"a seoro.{kind.__name__}", f"for example {example}")


# `None` is valid where it is the default.
_CONVERSIONS: Mapping[str, Callable[[str, object], Any]] = {
    "name": to_text,
    "seed": to_whole,
    "overrides": to_overrides,
    "parameters": to_path,
    "constraints": to_texts,
    "clock": to_text,
    "simulator": _instance(Simulator, 'seoro.Simulator(name="mujoco")'),
    "ros": _instance(Ros, 'seoro.Ros("tcp/192.168.0.7:7447")'),
    "bag": to_path,
    "lab": _instance(Lab, 'seoro.Lab("hall.yaml")'),
    "leasing": _instance(Leasing, "seoro.Leasing(wait=60.0)"),
    "observers": list_of(_to_observer, "a list of objects with a method `record`"),
    "output_directory": to_path,
    "keep_trace": to_flag,
    "poses": to_pose_rate,
    "scans": to_pose_rate,
    "grace": to_number,
    "timeout": to_limit,
    "external": to_texts,
    "replay": instance_of(Sequence, "a list of records"),
    "vet": to_function,
    "load": to_function,
    "locate": to_function,
    "debugger": _to_debugger,
}

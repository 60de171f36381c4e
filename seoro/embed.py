"""Loading and running scenarios from Python.

    scenario = seoro.load("maze.osc")
    async with seoro.start(scenario, seed=7) as run:
        async for record in run.trace():
            ...
    result = await run.result()

A run lives inside of the caller's event loop, in a task group of its own. It installs no signal handlers, touches
no global logging, and when the caller is cancelled it cleans up and leaves nothing behind. `run` is for scripts
that have no event loop.
"""

from __future__ import annotations

import asyncio
import math
import secrets
from collections.abc import AsyncIterator, Iterable, Iterator, Mapping, Sequence
from contextlib import AbstractAsyncContextManager, asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from pathlib import Path
from types import ModuleType
from typing import TYPE_CHECKING, Any, Literal, TypedDict, Unpack, get_args

import anyio
import anyio.lowlevel

from seoro import __version__
from seoro.background import background
from seoro.bindings.implementations import BoundFunctions
from seoro.bindings.load import bind_sources
from seoro.errors import BackendError, InvalidScenario, InvalidUse
from seoro.lang.frontend import Checked, lower
from seoro.lang.frontend import load as load_sources
from seoro.lang.loader import Reader, read_file
from seoro.lang.lower.entry import find_entry
from seoro.lang.recorder import Recorder
from seoro.parameters import read_parameters
from seoro.runtime.clock import RealClock, SimulatorClock, VirtualClock
from seoro.runtime.contracts import Backend, Clock, Observer
from seoro.runtime.homes import Placement
from seoro.runtime.outputs import OutputFile
from seoro.runtime.reading import ReadClock, Readers, TraceReader
from seoro.runtime.run import Execution, Settings
from seoro.runtime.verdict import Verdict

if TYPE_CHECKING:
    from seoro.bridges.ros2.backend import RosBackend
    from seoro.bridges.sim.node import SimulatorNode
    from seoro.bridges.wire import Artifact
    from seoro.film import Film, Recording
    from seoro.runtime.accept import Acceptance

SEED_BITS = 32  # of a seed that is drawn
OF_ROS = "ros"  # names the simulator of a ROS 2 system
ROS_ROUTER = "tcp/127.0.0.1:7447"  # where rmw_zenohd and the bridge for DDS listen
MAX_SEED = 2**63 - 1  # goes into messages for simulators

ClockName = Literal["real", "virtual", "sim"]


@dataclass(frozen=True)
class Scenario:
    """A scenario file that has been checked.

    Args:
        checked: The file with all that it imports.
        functions: The functions that carry out actions and modifiers.
    """

    checked: Checked
    functions: BoundFunctions


def check_file(
    path: str | Path,
    *,
    strict: bool = False,
    import_python: bool = True,
    modules: Iterable[ModuleType] = (),
    read: Reader = read_file,
    recorder: Recorder | None = None,
) -> Scenario:
    """Parse and check a file; errors in its text, and in what it is bound to, stand in `.checked.diagnostics`.

    Args:
        path: The file.
        strict: Report the use of extensions to the standard, too.
        import_python: Whether to import the Python modules of its libraries and external methods, which runs them,
            and to match them with declarations. Without them it cannot be run.
        modules: As `load`.
        read: Gives the texts of files.
        recorder: Is told what names mean and of what types values are.
    """
    sources = load_sources(Path(path), str(path), read)
    bound = bind_sources(sources, strict=strict, is_own_only=not import_python, given=modules, recorder=recorder)
    return Scenario(bound.checked, bound.functions)


def load(path: str | Path, *, modules: Iterable[ModuleType] = ()) -> Scenario:
    """Load a scenario file, and the Python modules of its libraries and external methods.

    Args:
        path: The file.
        modules: Python modules with actions, beside those of libraries, and before them.

    Raises:
        InvalidScenario: It has errors; the exception prints them with their places.
    """
    scenario = check_file(path, modules=modules)
    if scenario.checked.errors:
        raise InvalidScenario(scenario.checked.errors)
    return scenario


@dataclass(frozen=True)
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


@dataclass(frozen=True)
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


@dataclass(frozen=True)
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


class Run:
    """A run that has been started with `start`."""

    def __init__(self, execution: Execution, seed: int, simulator: SimulatorNode | None, readers: Readers) -> None:
        self._execution = execution
        self._simulator = simulator
        self._readers = readers
        self._done = anyio.Event()
        self.seed = seed

    @property
    def parameters(self) -> dict[str, object]:
        """The chosen value of every parameter of the scenario."""
        return self._execution.parameters

    @property
    def verdict(self) -> Verdict | None:
        """The verdict; None while the run goes on."""
        return self._execution.verdict if self._done.is_set() else None

    @property
    def now(self) -> float:
        """The time since the start of the run, on its clock [s]."""
        return self._execution.now

    @property
    def fault(self) -> Exception | None:
        """The exception of an action's own code that ended the run, if one did."""
        return self._execution.fault

    @property
    def files(self) -> tuple[OutputFile, ...]:
        """The files that actions have left in the output folder, such as pictures of cameras."""
        return self._execution.files

    @property
    def simulator(self) -> SimulatorNode | None:
        """The simulator of the run, if it has one."""
        return self._simulator

    def trace(self) -> TraceReader:
        """The records of the trace, from the first to `run.end`, as they come.

        Any number of readers may read at once. A run that is started without `keep_trace` keeps the last 1000
        records only, and waits for slow readers if its clock is virtual or a simulator's: begin to read early.

        Raises:
            InvalidUse: The first records are not kept any more.
        """
        return self._readers.open()

    async def result(self) -> Verdict:
        """The verdict, once there is one. Does not raise when the scenario fails."""
        await self._done.wait()
        assert self._execution.verdict is not None, "every way to end a run gives one"
        return self._execution.verdict

    def stop(self, reason: str = "stopped by the program") -> None:
        """Cancel the run; what it started is cleaned up first."""
        self._readers.wait_no_more()
        self._execution.stop(reason)

    def give_up(self, reason: str) -> None:
        """End the run as an error, without a verdict on the system under test."""
        self._readers.wait_no_more()
        self._execution.fail_backend(reason)

    async def artifacts(self) -> tuple[Artifact, ...]:
        """What the simulator has to show of the run, such as a picture; empty when it is gone."""
        if self._simulator is None:
            return ()
        try:
            return await self._simulator.artifacts()
        except BackendError:
            return ()

    def recording(self, film: Film, file: Path) -> AbstractAsyncContextManager[Recording]:
        """Record a film of the simulator while a block lasts, in which the run runs; see `seoro.film`."""
        from seoro.film import recording  # noqa: PLC0415 - with the messages of simulators, as `_open`

        if self._simulator is None:
            raise InvalidUse("a film is of a simulator, and there is none", help="add `--sim mujoco`")
        return recording(self._simulator, film, file)

    @asynccontextmanager
    async def running(self) -> AsyncIterator[None]:
        """Run while the block lasts: when it ends, the run is stopped, if it is not over, and has cleaned up."""
        async with background() as group:
            group.start_soon(self._carry)
            try:
                yield
            finally:
                self.stop("the block that started it has ended")  # of no effect when the run is over

    async def _carry(self) -> None:
        try:
            # Also in a loop that starts tasks eagerly, the block begins before the run, and can read it all.
            await anyio.lowlevel.cancel_shielded_checkpoint()
            await self._execution.run()
        finally:
            self._done.set()
            self._readers.end()


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
        observers: Called with every record of the trace.
        output_directory: Where the results of the run go; methods of libraries may ask for it.
        keep_trace: Whether to hold the whole trace in memory, so that `Run.trace` can be read at any time.
        grace: Time for the clean-up of a cancelled action [s].
    """

    name: str | None = None
    seed: int | None = None
    overrides: Mapping[str, str] = field(default_factory=dict)
    parameters: Path | None = None
    clock: ClockName | None = None
    simulator: Simulator | None = None
    ros: Ros | None = None
    lab: Lab | None = None
    observers: Sequence[Observer] = ()
    output_directory: Path | None = None
    keep_trace: bool = False
    grace: float = 5.0


class OptionFields(TypedDict, total=False):
    """The fields of `Options`, as keyword arguments."""

    name: str | None
    seed: int | None
    overrides: Mapping[str, str]
    parameters: Path | None
    clock: ClockName | None
    simulator: Simulator | None
    ros: Ros | None
    lab: Lab | None
    observers: Sequence[Observer]
    output_directory: Path | None
    keep_trace: bool
    grace: float


@asynccontextmanager
async def start(scenario: Scenario, **options: Unpack[OptionFields]) -> AsyncIterator[Run]:
    """Start a run; it is stopped, and has cleaned up, when the block ends.

    Args:
        scenario: What `load` returned.
        options: The fields of `Options`, by name.

    Raises:
        InvalidScenario, InvalidUse: It cannot be run like this; nothing has happened then.
        BackendError: The simulator did not start.
    """
    async with prepare(scenario, Options(**options)) as run, run.running():
        yield run


def run(scenario: Scenario, **options: Unpack[OptionFields]) -> Verdict:
    """Run a scenario to its end, for scripts that have no event loop: one is made for it.

    Ctrl-C stops the run, which cleans up, and is raised then.

    Args:
        scenario: What `load` returned.
        options: The fields of `Options`, by name; `observers` see the trace.

    Raises:
        InvalidScenario, InvalidUse, BackendError: As `start`; `InvalidUse` also if there is an event loop.
    """
    try:
        asyncio.get_running_loop()
    except RuntimeError:
        return asyncio.run(_run(scenario, options))
    raise InvalidUse(
        "`seoro.run` makes an event loop, and here is one already",
        help="run it there: `async with seoro.start(scenario) as run: verdict = await run.result()`",
    )


async def _run(scenario: Scenario, options: OptionFields) -> Verdict:
    async with start(scenario, **options) as started:
        return await started.result()


@asynccontextmanager
async def prepare(scenario: Scenario, options: Options) -> AsyncIterator[Run]:
    """Instantiate a run without starting it; what it needs is open while the block lasts.

    Raises:
        InvalidScenario, InvalidUse, BackendError: As `start`.
    """
    clock, rate = _check(options)
    overrides = _overrides(scenario, options)
    plan = lower(scenario.checked, options.name, overrides)
    seed = secrets.randbits(SEED_BITS) if options.seed is None else options.seed
    readers = Readers(options.keep_trace)
    async with _backends(options, seed, plan.entry) as (node, backends, placements), _reached(options) as systems:
        settings = Settings(
            seed=seed,
            clock=_clock(clock, node, rate, readers),
            backends=(*backends, *systems),
            placements=placements,
            observers=(readers, *options.observers),
            actions=scenario.functions.actions,
            modifiers=scenario.functions.modifiers,
            output_directory=options.output_directory,
            overrides=overrides,
            grace=options.grace,
            version=__version__,
        )
        yield Run(Execution(plan, settings), seed, node, readers)


def accept(scenario: Scenario, records: Sequence[Mapping[str, Any]]) -> Acceptance:
    """Whether the trace of a run is accepted by its scenario (7.6), by a check that is independent of the runtime.

    Args:
        scenario: What `load` returned.
        records: The records of the trace, as `Run.trace` gives them or as they are in a file.

    Raises:
        InvalidScenario, InvalidUse: The trace is of a scenario that is not in the file, or sets what that does not
            have.
    """
    from seoro.runtime.accept import check_trace  # noqa: PLC0415 - a seventh of what a run loads, which does without

    start: Mapping[str, Any] = next((each for each in records if each.get("kind") == "run.start"), {})
    name, overrides = start.get("scenario"), start.get("overrides", {})
    if not isinstance(name, str) or not isinstance(overrides, dict):
        raise InvalidUse("the trace does not say what was run: `run.start` needs `scenario` and `overrides`")
    plan = lower(scenario.checked, name, {str(path): str(value) for path, value in overrides.items()})
    return check_trace(plan, records)


def _overrides(scenario: Scenario, options: Options) -> Mapping[str, str]:
    if options.parameters is None:
        return options.overrides
    entry = find_entry(scenario.checked, options.name).qualified_name
    return {**read_parameters(options.parameters, entry), **options.overrides}


@asynccontextmanager
async def _backends(
    options: Options, seed: int, purpose: str
) -> AsyncIterator[tuple[SimulatorNode | None, tuple[Backend, ...], Mapping[str, Placement]]]:
    """The simulator of a run, all its backends, and where actors live for whom that is said."""
    if options.lab is not None:
        from seoro.bridges.models import ModelPath  # noqa: PLC0415 - Zenoh, for runs with simulators or robots
        from seoro.lab.opening import open_lab  # noqa: PLC0415 - the same
        from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file

        lab = read_lab(options.lab.file)
        async with open_lab(lab, seed, ModelPath(options.lab.model_path), f"the scenario {purpose}") as opened:
            yield opened.simulator, opened.backends, opened.placements
    elif options.simulator is not None:
        async with _open(options.simulator, seed, options.ros) as node:
            yield node, (node,), {}
    else:
        yield None, (), {}


@asynccontextmanager
async def _open(simulator: Simulator, seed: int, ros: Ros | None) -> AsyncIterator[SimulatorNode]:
    # Zenoh and the message models are loaded for runs that have a simulator only.
    from seoro.bridges.launch import SimulatorOptions, connect_simulator, start_simulator  # noqa: PLC0415
    from seoro.bridges.models import ModelPath  # noqa: PLC0415
    from seoro.bridges.snapshots import read_snapshot  # noqa: PLC0415

    snapshot = read_snapshot(simulator.snapshot) if simulator.snapshot is not None else None
    options = SimulatorOptions(simulator.world, seed, ModelPath(simulator.model_path), snapshot)
    if simulator.endpoint is not None:
        async with connect_simulator(simulator.endpoint, options) as node:
            yield node
        return
    name = simulator.name or (snapshot.engine if snapshot is not None else None)
    assert name is not None, "checked before"
    if name == OF_ROS:
        system = ros or Ros(ROS_ROUTER)
        with _asking_for_ros():
            from seoro.bridges.ros2.backend import RosOptions  # noqa: PLC0415 - an extra
            from seoro.bridges.ros2.simulators.opening import open_simulator  # noqa: PLC0415 - the same
        reached = RosOptions(system.endpoint, system.domain, system.dialect, system.interfaces)
        async with open_simulator(reached, options) as node:
            yield node
        return
    async with start_simulator(name, options) as node:
        yield node


@asynccontextmanager
async def _reached(options: Options) -> AsyncIterator[tuple[RosBackend, ...]]:
    """The ROS 2 system of a run, if it has one."""
    if options.ros is None:
        yield ()
        return
    with _asking_for_ros():
        from seoro.bridges.ros2.backend import RosOptions, open_backend  # noqa: PLC0415 - an extra
    ros = options.ros
    async with open_backend(RosOptions(ros.endpoint, ros.domain, ros.dialect, ros.interfaces)) as system:
        yield (system,)


@contextmanager
def _asking_for_ros() -> Iterator[None]:
    """Say how to install what speaks with ROS 2, which is an extra, where it is loaded and is not there."""
    try:
        yield
    except ModuleNotFoundError as error:
        raise InvalidUse(
            f"what reaches ROS 2 systems is not installed: there is no module '{error.name}'",
            help="pip install 'seoro[ros2]'",
        ) from error


def _check(options: Options) -> tuple[ClockName, float]:
    """Refuse options that cannot be, before anything is started.

    Returns:
        The clock of the run, and the rate of its simulator.
    """
    if options.seed is not None and not 0 <= options.seed <= MAX_SEED:
        raise InvalidUse(f"a seed is a whole number from 0 to {MAX_SEED}, not {options.seed}")
    if not options.grace >= 0:
        raise InvalidUse(f"the time for a clean-up is a number of seconds from 0, not {options.grace}")
    if options.clock not in (None, *get_args(ClockName)):
        raise InvalidUse(f"there is no clock '{options.clock}'", help=f"clocks: {', '.join(get_args(ClockName))}")
    if options.ros is not None and options.clock == "virtual":
        raise InvalidUse("a ROS 2 system does not wait for the clock 'virtual'", help="leave out `--clock`")
    if options.lab is not None:
        return _check_lab(options, options.lab)
    if options.simulator is not None:
        return _check_simulator(options, options.simulator)
    if options.clock == "sim":
        raise InvalidUse("the clock 'sim' is that of a simulator, and there is none", help="add `--sim mujoco`")
    return options.clock or "real", math.inf


def _check_simulator(options: Options, simulator: Simulator) -> tuple[ClockName, float]:
    _check_clock(options, "sim", "a simulator")
    if simulator.snapshot is not None and simulator.world is not None:
        raise InvalidUse("a snapshot has its own world", help="leave out the other world, or the snapshot")
    named = [each for each in (simulator.name, simulator.endpoint) if each is not None]
    if len(named) > 1 or not (named or simulator.snapshot):
        raise InvalidUse("a simulator is either started by its name or connected to at its endpoint")
    _check_rate(simulator.rate)
    return "sim", simulator.rate


def _check_lab(options: Options, given: Lab) -> tuple[ClockName, float]:
    from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file, for runs that have one

    if options.simulator is not None:
        raise InvalidUse("a lab has its own simulator", help="leave out the other simulator, or the lab")
    lab = read_lab(given.file)
    clock: ClockName = "real" if lab.simulator is None else "sim"
    _check_clock(options, clock, "robots" if lab.simulator is None else "a simulator")
    if not lab.bridges:
        rate = math.inf if given.rate is None else given.rate
        _check_rate(rate)
        return clock, rate
    if given.rate not in (None, 1.0):
        raise InvalidUse(
            f"robots move in real time, and the lab has some: the rate is 1, not {given.rate:g}",
            help="leave out `--rate`",
        )
    return clock, 1.0


def _check_clock(options: Options, clock: ClockName, beside: str) -> None:
    if options.clock not in (None, clock):
        raise InvalidUse(f"the clock '{options.clock}' does not go with {beside}", help="leave out `--clock`")


def _check_rate(rate: float) -> None:
    if not rate > 0:
        raise InvalidUse(f"the rate of a simulator is above 0, not {rate}")


def _clock(name: ClockName, node: SimulatorNode | None, rate: float, readers: Readers) -> Clock:
    if node is not None:
        return ReadClock(SimulatorClock(node, rate), readers)
    return ReadClock(VirtualClock(), readers) if name == "virtual" else RealClock()

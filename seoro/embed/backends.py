"""Opening of the backends of a run (simulator, robots, ROS 2 system), and its clock."""

from __future__ import annotations

from collections.abc import AsyncIterator, Callable, Mapping
from contextlib import AbstractAsyncContextManager, asynccontextmanager
from dataclasses import field
from functools import cache, partial
from pathlib import Path
from types import MappingProxyType
from typing import TYPE_CHECKING

from seoro.bridges.addresses import ROS_ROUTER
from seoro.embed.options import ROS_SIMULATOR, ClockName, Options, Ros, Simulator
from seoro.errors import UsageError
from seoro.files.world_names import WorldName
from seoro.lang.frozen import Value
from seoro.lang.plan import ActorType, Plan
from seoro.runtime.contracts.backends import Backend
from seoro.runtime.execution.assignment import Placement
from seoro.runtime.kernel.clock import (
    Clock,
    FollowedClock,
    RealClock,
    Settle,
    SimulatorClock,
    TimeServer,
    VirtualClock,
)
from seoro.runtime.trace.reader import ReadClock, Readers

if TYPE_CHECKING:
    from anyio.abc import TaskGroup

    from seoro.bridges.ros2.backend import RosBackend
    from seoro.bridges.ros2.participant import RosOptions
    from seoro.bridges.ros2.recording.bag_system import BagSystem
    from seoro.bridges.sim.node import SimulatorNode
    from seoro.lab.resetting import Reset
    from seoro.lab.selectors import Selector
    from seoro.lab.teardown import Teardown
    from seoro.runtime.contracts.ros2 import RobotNames
    from seoro.runtime.debug.debugger import Debugger


class OpenBackends(Value):
    """Backends of a run.

    Args:
        simulator: Simulator, if any.
        time: Time server of the run, if any: a simulator or a bag.
        backends: All backends.
        placements: Explicit assignments of actors to robots.
        teardown: Teardown of its robots after the run.
        settle: See `FollowedClock`; None if no tasks follow the time of the run.
    """

    simulator: SimulatorNode | None = None
    time: TimeServer | None = None
    backends: tuple[Backend, ...] = ()
    placements: Mapping[str, Placement] = field(default_factory=dict)
    teardown: Teardown | None = None
    settle: Settle | None = None


@asynccontextmanager
async def open_backends(
    options: Options, seed: int, plan: Plan, selectors: Mapping[str, Selector]
) -> AsyncIterator[OpenBackends]:
    """Open the backends of a run, except ROS 2 systems, while the block lasts.

    Args:
        options: Options of the run.
        seed: Random seed of the run.
        plan: Plan of the run.
        selectors: Selectors of robots, by actors.
    """
    if options.lab is not None:
        from seoro.bridges.launch import SimulatorOptions  # noqa: PLC0415 - Zenoh, for runs with simulators or robots
        from seoro.bridges.models import ModelPath  # noqa: PLC0415 - the same
        from seoro.lab.opening import open_lab  # noqa: PLC0415 - the same
        from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file
        from seoro.lab.waiting import retry_until_free  # noqa: PLC0415 - Zenoh

        lab = read_lab(options.lab.file)
        if lab.is_recorded:
            from seoro.lab.recorded import open_recorded  # noqa: PLC0415 - for runs with recorded robots

            yield open_recorded(lab, actor_names(plan), selectors)
            return
        models = ModelPath(options.lab.model_path, options.locate, expands=True)
        world = lab.world and WorldName.parse(lab.world).located(models.locate)
        simulation = SimulatorOptions(world, seed, models)
        opening = partial(
            open_lab, lab, simulation, resets_of(options), _purpose(plan), actor_names(plan), selectors
        )
        async with retry_until_free(options.leasing, opening) as opened:
            yield opened
    elif options.simulator is not None:
        async with _open(options.simulator, seed, options, _purpose(plan)) as node:
            yield OpenBackends(node, node, (node,))
    elif options.bag is not None:
        yield observing(open_bag_system(options.bag))
    else:
        yield OpenBackends()


def open_bag_system(
    path: Path,
    robots: Mapping[str, RobotNames] | None = None,
    *,
    is_alone: bool = True,
    tasks: TaskGroup | None = None,
) -> BagSystem:
    """Open a bag as the ROS 2 system of a run.

    Args:
        path: The bag.
        robots: See `BagSystem`.
        is_alone: See `BagSystem`.
        tasks: Task group that plays the bag by the clock of this machine; None if the run has another clock.

    Raises:
        UsageError: The extra `ros2` is not installed, or the bag is unreadable.
    """
    try:
        from seoro.bridges.ros2.recording.bag_system import BagSystem  # noqa: PLC0415 - an extra
        from seoro.bridges.ros2.recording.bag_time import PlayedBag  # noqa: PLC0415 - an extra
        from seoro.bridges.ros2.recording.reader import open_bag  # noqa: PLC0415 - an extra
    except ModuleNotFoundError as error:
        raise _missing_extra(error) from error
    bag = open_bag(path)
    return BagSystem(bag, robots, is_alone=is_alone) if tasks is None else PlayedBag(bag, robots or {}, tasks)


def observing(system: BagSystem, placements: Mapping[str, Placement] = MappingProxyType({})) -> OpenBackends:
    """Return the backends of a run whose clock is a bag.

    Args:
        system: The bag.
        placements: Assignments of actors to its robots.
    """
    from seoro.bridges.ros2.recording.bag_time import BagTime  # noqa: PLC0415 - an extra

    return OpenBackends(time=BagTime(system), settle=system.settle, backends=(system,), placements=placements)


def _missing_extra(error: ModuleNotFoundError) -> UsageError:
    return UsageError(
        f"ROS 2 support is not installed: module '{error.name}' not found", help="pip install 'seoro[ros2]'"
    )


def resets_of(options: Options) -> Callable[[Path, str], Reset]:
    """Make a function that loads reset scenarios, each once.

    Args:
        options: Options of the run.
    """
    from seoro.embed.scenarios import load  # noqa: PLC0415 - parser and checks
    from seoro.lab.resetting import Reset  # noqa: PLC0415 - Zenoh
    from seoro.lang.frontend import lower  # noqa: PLC0415 - parser and checks

    @cache
    def loaded(path: Path) -> Reset:
        scenario = (options.load or load)(path)
        plan = lower(scenario.checked, None, {})
        if options.vet is not None:
            options.vet(plan)
        return Reset(plan, scenario.functions)

    def reset_of(path: Path, place: str) -> Reset:
        reset = loaded(path)
        actors = actor_names(reset.plan)
        if len(actors) != 1:
            found = ", ".join(sorted(actors)) or "none"
            raise UsageError(
                f"{place}: the reset scenario {reset.plan.entry} in {path} must have exactly one actor, the robot "
                f"(found {found})"
            )
        return reset

    return reset_of


def _purpose(plan: Plan) -> str:
    """Describe the purpose of a lease, for other clients that want the robots."""
    from seoro.embed.whoami import whoami  # noqa: PLC0415 - for runs with robots or simulators

    return f"the scenario {plan.entry} of {whoami()}"


def _open(
    simulator: Simulator, seed: int, settings: Options, purpose: str
) -> AbstractAsyncContextManager[SimulatorNode]:
    # Zenoh and the message models are loaded only for runs with a simulator.
    from seoro.bridges.launch import SimulatorOptions, connect_simulator, start_simulator  # noqa: PLC0415
    from seoro.bridges.models import ModelPath  # noqa: PLC0415
    from seoro.bridges.snapshots import read_snapshot  # noqa: PLC0415

    snapshot = read_snapshot(simulator.snapshot) if simulator.snapshot is not None else None
    options = SimulatorOptions(
        simulator.world, seed, ModelPath(simulator.model_path, settings.locate, expands=True), snapshot
    )
    if simulator.endpoint is not None:
        from seoro.lab.waiting import retry_until_free  # noqa: PLC0415 - Zenoh

        opening = partial(connect_simulator, simulator.endpoint, options, None, purpose)
        return retry_until_free(settings.leasing, opening)
    name = simulator.name or (snapshot.engine if snapshot is not None else None)
    assert name is not None, "checked before"
    if name == ROS_SIMULATOR:
        system = _ros_options(settings.ros or Ros(ROS_ROUTER))
        from seoro.bridges.ros2.simulators.opening import open_simulator  # noqa: PLC0415 - an extra

        return open_simulator(system, options)
    return start_simulator(name, options)


@asynccontextmanager
async def open_ros(options: Options) -> AsyncIterator[tuple[RosBackend, ...]]:
    """Connect to the ROS 2 system of a run, if any, while the block lasts."""
    if options.ros is None:
        yield ()
        return
    settings = _ros_options(options.ros)
    from seoro.bridges.ros2.backend import open_backend  # noqa: PLC0415 - an extra

    is_alone = options.simulator is None and options.lab is None
    async with open_backend(settings, is_alone=is_alone, has_state=options.ros.state) as system:
        yield (system,)


def _ros_options(ros: Ros) -> RosOptions:
    """Convert the options of a ROS 2 system.

    Raises:
        UsageError: The extra `ros2` is not installed.
    """
    try:
        import seoro.bridges.ros2.backend  # noqa: F401, PLC0415 - needs all packages of the extra
        from seoro.bridges.ros2.participant import RosOptions  # noqa: PLC0415 - an extra
    except ModuleNotFoundError as error:
        raise _missing_extra(error) from error
    return RosOptions(ros.endpoint, ros.domain, ros.dialect, ros.interfaces)


def make_clock(
    name: ClockName, opened: OpenBackends, rate: float, readers: Readers, debugger: Debugger | None = None
) -> Clock:
    """Make the clock of a run.

    Args:
        name: Name of the clock.
        opened: Backends of the run, with the simulator or bag that provides the time, if any.
        rate: Rate of the simulator, in simulated seconds per second.
        readers: Readers of the trace; virtual and simulated time wait for them.
        debugger: Debugger of the run, which stops its time, too.

    Raises:
        UsageError: The clock cannot be stopped for the debugger.
    """
    node = opened.time
    if node is None and name != "virtual":
        if debugger is not None:
            raise UsageError(
                "a run on the real clock cannot be paused", help="choose the virtual clock, or a simulator"
            )
        return RealClock()
    clock: VirtualClock | SimulatorClock
    if node is None:
        clock = VirtualClock()
    elif opened.settle is None:
        clock = SimulatorClock(node, rate)
    else:
        clock = FollowedClock(node, rate, opened.settle)
    if debugger is None:
        return ReadClock(clock, readers)
    from seoro.runtime.debug.clock import DebugClock  # noqa: PLC0415 - for runs that are debugged

    return ReadClock(DebugClock(clock, debugger), readers)


def actor_names(plan: Plan) -> frozenset[str]:
    """Return the names of the actors of the entry scenario."""
    fields = plan.scenarios[plan.entry].structure.fields
    return frozenset(name for name, each in fields.items() if isinstance(each.type, ActorType))

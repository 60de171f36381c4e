"""Opening what a run needs: simulators, robots, ROS 2 systems; and the clock that follows from them."""

from __future__ import annotations

from collections.abc import AsyncIterator, Iterator, Mapping
from contextlib import asynccontextmanager, contextmanager
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

from seoro.bridges.ros2.addresses import ROUTER
from seoro.embed.options import OF_ROS, ClockName, Options, Ros, Simulator
from seoro.errors import InvalidUse
from seoro.lang.plan import ActorType, Plan
from seoro.runtime.clock import RealClock, SimulatorClock, VirtualClock
from seoro.runtime.contracts import Backend, Clock
from seoro.runtime.homes import Placement
from seoro.runtime.reading import ReadClock, Readers

if TYPE_CHECKING:
    from seoro.bridges.ros2.backend import RosBackend
    from seoro.bridges.sim.node import SimulatorNode
    from seoro.lab.aftermath import Aftermath
    from seoro.lab.wishes import Wish


@dataclass(frozen=True)
class Opened:
    """What a run has.

    Args:
        simulator: Its simulator, if it has one.
        backends: All of it.
        placements: Where actors live for whom that is said.
        aftermath: What is done with its robots after it.
    """

    simulator: SimulatorNode | None = None
    backends: tuple[Backend, ...] = ()
    placements: Mapping[str, Placement] = field(default_factory=dict)
    aftermath: Aftermath | None = None


@asynccontextmanager
async def open_backends(
    options: Options, seed: int, purpose: str, actors: frozenset[str], wishes: Mapping[str, Wish]
) -> AsyncIterator[Opened]:
    """What a run needs, but for ROS 2 systems, for as long as the block lasts.

    Args:
        options: How it is run.
        seed: Of everything that is drawn.
        purpose: What robots are held for, for others who want them.
        actors: Names of the scenario's actors.
        wishes: What actors are to be, for whom that is said.
    """
    if options.lab is not None:
        from seoro.bridges.models import ModelPath  # noqa: PLC0415 - Zenoh, for runs with simulators or robots
        from seoro.lab.opening import Wanted, open_lab  # noqa: PLC0415 - the same
        from seoro.lab.reading import read_lab  # noqa: PLC0415 - the form of the file
        from seoro.lab.waiting import when_free  # noqa: PLC0415 - Zenoh

        lab = read_lab(options.lab.file)
        from seoro.embed.resets import resets_of  # noqa: PLC0415 - as above

        wanted = Wanted(
            seed, ModelPath(options.lab.model_path, options.locate), resets_of(options), purpose, actors, wishes
        )
        async with when_free(options.leasing, partial(open_lab, lab, wanted)) as opened:
            yield Opened(opened.simulator, opened.backends, opened.placements, opened.aftermath)
    elif options.simulator is not None:
        async with _open(options.simulator, seed, options, purpose) as node:
            yield Opened(node, (node,))
    else:
        yield Opened()


@asynccontextmanager
async def _open(simulator: Simulator, seed: int, settings: Options, purpose: str) -> AsyncIterator[SimulatorNode]:
    # Zenoh and the message models are loaded for runs that have a simulator only.
    from seoro.bridges.launch import SimulatorOptions, connect_simulator, start_simulator  # noqa: PLC0415
    from seoro.bridges.models import ModelPath  # noqa: PLC0415
    from seoro.bridges.snapshots import read_snapshot  # noqa: PLC0415

    snapshot = read_snapshot(simulator.snapshot) if simulator.snapshot is not None else None
    options = SimulatorOptions(simulator.world, seed, ModelPath(simulator.model_path, settings.locate), snapshot)
    if simulator.endpoint is not None:
        from seoro.lab.waiting import when_free  # noqa: PLC0415 - Zenoh

        opening = partial(connect_simulator, simulator.endpoint, options, None, purpose)
        async with when_free(settings.leasing, opening) as node:
            yield node
        return
    name = simulator.name or (snapshot.engine if snapshot is not None else None)
    assert name is not None, "checked before"
    if name == OF_ROS:
        system = settings.ros or Ros(ROUTER)
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
async def open_ros(options: Options) -> AsyncIterator[tuple[RosBackend, ...]]:
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


def clock_of(name: ClockName, node: SimulatorNode | None, rate: float, readers: Readers) -> Clock:
    """The clock of a run.

    Args:
        name: What it is called.
        node: The simulator whose clock it is, if there is one.
        rate: Of that simulator, in simulated seconds per second.
        readers: Of the trace, who must not be left behind where time does not pass by itself.
    """
    if node is not None:
        return ReadClock(SimulatorClock(node, rate), readers)
    return ReadClock(VirtualClock(), readers) if name == "virtual" else RealClock()


def actors_of(plan: Plan) -> frozenset[str]:
    """Names of the actors of the scenario that is run."""
    fields = plan.scenarios[plan.entry].structure.fields
    return frozenset(name for name, each in fields.items() if isinstance(each.type, ActorType))

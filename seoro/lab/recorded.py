"""Recorded robots of a lab, which a run observes as they were when their bag was recorded."""

from __future__ import annotations

from collections.abc import AsyncIterator, Collection, Mapping
from contextlib import asynccontextmanager
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Final

from anyio.abc import TaskGroup

from seoro.bridges import wire
from seoro.concurrency.background import background
from seoro.embed.backends import OpenBackends, observing, open_bag_system
from seoro.errors import UsageError
from seoro.lab.binding import bind
from seoro.lab.reading import Lab
from seoro.lab.selectors import Selector
from seoro.runtime.contracts.ros2 import RobotNames
from seoro.runtime.execution.assignment import Home, Placement

if TYPE_CHECKING:
    from seoro.bridges.ros2.recording.bag_system import BagSystem
    from seoro.bridges.sim.node import SimulatorNode
    from seoro.runtime.kernel.clock import TimeServer

TF: Final = "tf"  # last name of topics of transforms


@dataclass(frozen=True)
class Recorded:
    """The recorded robots of a run.

    Args:
        system: Their bag.
        placements: Assignments of actors to them.
    """

    system: BagSystem
    placements: Mapping[str, Placement]

    def time_beside(self, simulator: SimulatorNode) -> TimeServer:
        """Return the time of a run with a simulator, beside which the bag begins with the run."""
        from seoro.bridges.ros2.recording.bag_time import SimulatedTime  # noqa: PLC0415 - an extra

        return SimulatedTime(simulator, self.system)


def open_recorded(lab: Lab, actors: Collection[str], selectors: Mapping[str, Selector]) -> OpenBackends:
    """Open the bag of a lab without other robots, and assign its robots to actors.

    Args:
        lab: A lab whose robots are all recorded.
        actors: Names of the actors of the scenario.
        selectors: Selectors of actors that have one.

    Raises:
        UsageError: A robot is unknown, or its bag cannot be observed; see `opening_bag`.
    """
    states = {name: wire.RobotState(name=name, kinds=()) for name in lab.robots}
    bound = bind(lab, actors, selectors, states, "", may_wait=False)
    system = _open_bag(lab, bound.values())
    return observing(system, _placements(lab, system, bound))


@asynccontextmanager
async def opening_bag(lab: Lab, bound: Mapping[str, str]) -> AsyncIterator[Recorded | None]:
    """Open the bag of a lab with other robots, while the block lasts; None if no actor has a recorded robot.

    Without a simulator, the bag is played by the clock of this machine.

    Args:
        lab: The lab.
        bound: Names of robots in the lab, by those of actors.

    Raises:
        UsageError: The extra `ros2` is not installed, the bag is unreadable, or it lacks the namespace of a robot.
    """
    if not any(lab.robots[robot].bag is not None for robot in bound.values()):
        yield None
        return
    async with background() as tasks:
        has_clock = lab.simulator is not None
        system = _open_bag(lab, bound.values(), is_alone=False, tasks=None if has_clock else tasks)
        yield Recorded(system, _placements(lab, system, bound))


def _open_bag(
    lab: Lab, bound: Collection[str], *, is_alone: bool = True, tasks: TaskGroup | None = None
) -> BagSystem:
    """Open the bag of a lab for the robots that actors have."""
    assert lab.bag is not None, "checked before"
    recorded = {name: _names_of(lab, name) for name, robot in lab.robots.items() if robot.bag is not None}
    first = next(iter(recorded))
    try:
        system = open_bag_system(lab.bag, recorded, is_alone=is_alone, tasks=tasks)
    except UsageError as error:
        raise UsageError(f"{lab.position_of(first)}: robots.{first}: {error.message}", help=error.help) from error
    for robot in bound:
        if robot in recorded and not topics_in(system.topics, recorded[robot].namespace):
            raise UsageError(
                f"{lab.position_of(robot)}: robots.{robot}: {system.name} has no topic in the namespace "
                f"/{recorded[robot].namespace}",
                help=f"topics: {', '.join(sorted(system.topics)) or 'none'}",
            )
    return system


def _names_of(lab: Lab, robot: str) -> RobotNames:
    """Return the names of the topics of a recorded robot, with those of its profile.

    Raises:
        UsageError: The profile cannot be used.
    """
    namespace, named = lab.robots[robot].namespace.strip("/"), lab.profile_of(robot)
    if named is None:
        return RobotNames(namespace)
    from seoro.bridges.ros2.robots.profile import read_profile  # noqa: PLC0415 - for robots with a profile

    try:
        profile = read_profile(str(named))
        if profile.tf.rpartition("/")[2] != TF:
            raise UsageError(f"unsupported name of transforms, '{profile.tf}': expected `{TF}` at its end")
    except UsageError as error:
        place = lab.position_of(robot)
        raise UsageError(f"{place}: robots.{robot}.profile: {error.message}", help=error.help) from error
    base = profile.base
    if base is None:
        return RobotNames(namespace, profile.tf)
    return RobotNames(namespace, profile.tf, base.odometry, base.pose)


def _placements(lab: Lab, system: BagSystem, bound: Mapping[str, str]) -> dict[str, Placement]:
    """Return the assignments of actors to recorded robots."""
    return {
        actor: Placement(Home(system, robot), None, lab.position_of(robot))
        for actor, robot in bound.items()
        if lab.robots[robot].bag is not None
    }


def topics_in(topics: Collection[str], namespace: str) -> list[str]:
    """Return the topics in a namespace, which has no slashes around it."""
    space = f"/{namespace}/".replace("//", "/")
    return [topic for topic in topics if topic.startswith(space)]


@dataclass(frozen=True)
class RecordedRobot:
    """A recorded robot in a lab file.

    Attributes:
        name: Name in the lab.
        type: Type in the lab file; empty without one.
        bag: Path of its bag.
        contents: Length of the bag and number of topics of the robot, as text; empty if it cannot be observed.
        problem: Reason why it cannot be observed; empty otherwise.
        advice: Suggestion for a fix; may be empty.
    """

    name: str
    type: str
    bag: str
    contents: str = ""
    problem: str = ""
    advice: str = ""


def recorded_robots(lab: Lab | None) -> list[RecordedRobot]:
    """Return the recorded robots of a lab file, with the contents of their bags."""
    found = []
    for name, robot in {} if lab is None else lab.robots.items():
        if lab is not None and robot.bag is not None:
            known = RecordedRobot(name, robot.type or "", str(lab.bag))
            try:
                system = _open_bag(lab, [name])
            except UsageError as error:
                found.append(replace(known, problem=error.message, advice=error.help))
                continue
            count = len(topics_in(system.topics, robot.namespace.strip("/")))
            topics = f"{count} topic{'' if count == 1 else 's'}"
            found.append(replace(known, contents=f"{system.duration:.1f} s, {topics}"))
    return found

"""Recorded robots of a lab: a run observes their bag, which is its clock."""

from __future__ import annotations

from collections.abc import Collection, Mapping

from seoro.bridges import wire
from seoro.embed.backends import OpenBackends, open_bag_system
from seoro.errors import UsageError
from seoro.lab.binding import bind
from seoro.lab.reading import Lab
from seoro.lab.selectors import Selector
from seoro.runtime.execution.assignment import Home, Placement


def open_recorded(lab: Lab, actors: Collection[str], selectors: Mapping[str, Selector]) -> OpenBackends:
    """Open the bag of a lab, and assign its robots to actors.

    Args:
        lab: A lab whose robots are recorded.
        actors: Names of the actors of the scenario.
        selectors: Selectors of actors that have one.

    Raises:
        UsageError: A robot is unknown, the extra `ros2` is not installed, the bag is unreadable, or it lacks the
            namespace of a robot.
    """
    assert lab.bag is not None, "checked before"
    states = {name: wire.RobotState(name=name, kinds=()) for name in lab.robots}
    bound = bind(lab, actors, selectors, states, "", may_wait=False)
    namespaces = {name: robot.namespace.strip("/") for name, robot in lab.robots.items()}
    first = next(iter(lab.robots))
    try:
        system = open_bag_system(lab.bag, namespaces)
    except UsageError as error:
        raise UsageError(f"{lab.position_of(first)}: robots.{first}: {error.message}", help=error.help) from error
    for robot in bound.values():
        space = f"/{namespaces[robot]}/".replace("//", "/")
        if not any(topic.startswith(space) for topic in system.topics):
            raise UsageError(
                f"{lab.position_of(robot)}: robots.{robot}: {system.name} has no topic in the namespace {space}",
                help=f"topics: {', '.join(sorted(system.topics)) or 'none'}",
            )
    placements = {
        actor: Placement(Home(system, robot), None, lab.position_of(robot)) for actor, robot in bound.items()
    }
    return OpenBackends(time=system, settle=system.settle, backends=(system,), placements=placements)

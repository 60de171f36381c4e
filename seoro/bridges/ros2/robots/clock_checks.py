"""Checks of the clocks of a robot: stamps of its messages, and the parameter `use_sim_time` of its nodes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Final

import anyio

from seoro.bridges.ros2.clients.parameters import get_parameters
from seoro.bridges.ros2.clock import TOPIC
from seoro.bridges.ros2.participant import RosNode
from seoro.bridges.ros2.robots.link import RobotLink
from seoro.bridges.wire import RobotProblem
from seoro.concurrency.gathering import gather
from seoro.errors import BackendError

PARAMETER: Final = "use_sim_time"
ANSWER_TIMEOUT: Final = 2.0  # [s]
MAX_OFFSET: Final = 0.5  # [s] between the clocks of machines
MAX_AGE: Final = 1.0  # [s] of stamps, ahead or behind
SYNCHRONISE: Final = "synchronise the clocks of both machines by NTP"


async def clock_problems(node: RosNode, others: Sequence[str]) -> list[RobotProblem]:
    """Return problems with the clocks of nodes.

    Args:
        node: Own node.
        others: Full names of the nodes of the robot.
    """
    published = bool(node.others(node.graph.publishers(TOPIC)))
    answers = dict(zip(others, await gather(lambda other: _uses_sim_time(node, other), others), strict=True))
    simulated = [name for name, answer in answers.items() if answer is True]
    real = [name for name, answer in answers.items() if answer is False]
    if simulated and not published:
        text = f"the simulated time of {', '.join(simulated)} stands still: {TOPIC} has no publisher"
        return [RobotProblem(text=text, help=f"start the simulator, or set `{PARAMETER}` to false")]
    if simulated and real:
        text = f"`{PARAMETER}` differs: true of {', '.join(simulated)}; false of {', '.join(real)}"
        return [RobotProblem(text=text, help="set it to the same value", is_fatal=False)]
    if published and real:
        text = f"{TOPIC} is published, but `{PARAMETER}` is false of {', '.join(real)}"
        return [RobotProblem(text=text, help="set it to true, or stop the clock", is_fatal=False)]
    return []


async def _uses_sim_time(node: RosNode, other: str) -> bool | None:
    """Return whether a node uses simulated time; None if it does not answer."""
    if node.graph.servers(f"{other}/get_parameters"):
        with anyio.move_on_after(ANSWER_TIMEOUT), suppress(BackendError):
            return bool((await get_parameters(node, other, [PARAMETER]))[PARAMETER])
    return None


def stamp_problems(link: RobotLink) -> Iterator[RobotProblem]:
    """Yield problems with the clock of the robot's machine, or with the stamps of its messages."""
    offsets = {topic: offset for topic, offset in link.clock_offsets().items() if abs(offset) > MAX_OFFSET}
    if offsets:
        topic, offset = max(offsets.items(), key=lambda item: abs(item[1]))
        text = f"the clock of the machine that publishes {topic} is {_described(offset)} that of the bridge"
        yield RobotProblem(text=text, help=SYNCHRONISE, is_fatal=False)
        return
    if link.node.others(link.node.graph.publishers(TOPIC)):
        return  # stamps are of simulated time
    for topic, (stamp, arrived) in link.stamps().items():
        if stamp and abs(stamp - arrived) > MAX_AGE:
            text = f"stamps on {topic} are {_described(stamp - arrived)} the clock"
            advice = f"correct the time of its publisher; stamps of a simulation need {TOPIC}"
            yield RobotProblem(text=text, help=advice, is_fatal=False)
            return


def _described(offset: float) -> str:
    return f"{abs(offset):.1f} s {'ahead of' if offset > 0.0 else 'behind'}"

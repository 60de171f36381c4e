"""Plan of a round: clients with scenarios, and faults. Drawn from a seed; data only."""

from __future__ import annotations

import random
from dataclasses import dataclass
from typing import Final, Literal

PARTS: Final = ("router", "simulator", "lab-a", "lab-b")
LINKS: Final = ("simulator", "lab-a", "lab-b", "clients")
ROBOTS: Final = ("turtlebot4", "second")
LENGTH: Final = 7.0  # [s] in which clients begin and faults happen

Kind = Literal["log", "wait", "fail", "drive"]
What = Literal["kill", "freeze", "cut", "slow", "kill_client", "kill_run", "kill_fork_server"]
EXECUTORS: Final = ("lab-a", "lab-b")
FAULTS: Final[tuple[What, ...]] = (
    "kill",
    "kill",
    "freeze",
    "cut",
    "slow",
    "kill_client",
    "kill_run",
    "kill_fork_server",
)


@dataclass(frozen=True)
class Submission:
    """A client that submits a scenario, and follows the run to its end.

    Args:
        number: Index in the round.
        kind: Kind of scenario: log at once, wait some real seconds, fail, or drive a robot.
        executor: Name of the executor.
        robot: Robot to drive; empty for the other kinds.
        at: Time from the start of the round [s].
        seconds: Duration of the wait or the drive [s].
        waits: Whether it waits for a robot that another run holds.
    """

    number: int
    kind: Kind
    executor: str
    robot: str
    at: float
    seconds: float
    waits: bool

    @property
    def expected(self) -> str:
        """The only verdict on the scenario that is right; a fault may lead to none."""
        return "failed" if self.kind == "fail" else "passed"


@dataclass(frozen=True)
class Fault:
    """A fault.

    Args:
        what: Kind of fault. `kill_run` and `kill_fork_server` are about processes of an executor.
        who: The part, link or client that it happens to.
        at: Time from the start of the round [s].
        seconds: Duration until a killed part is restarted, or a link is restored [s].
    """

    what: What
    who: str
    at: float
    seconds: float


@dataclass(frozen=True)
class Round:
    """A round.

    Args:
        seed: The seed that it was drawn from.
        submissions: Its clients.
        faults: Its faults.
    """

    seed: int
    submissions: tuple[Submission, ...]
    faults: tuple[Fault, ...]


def draw(seed: int) -> Round:
    """Draw a round."""
    chance = random.Random(seed)
    submissions = tuple(_submission(number, chance) for number in range(chance.randint(2, 4)))
    faults = tuple(_fault(chance, len(submissions)) for _ in range(chance.randint(1, 3)))
    return Round(seed, submissions, faults)


def _submission(number: int, chance: random.Random) -> Submission:
    kind: Kind = chance.choice(("log", "wait", "fail", "drive", "drive"))
    return Submission(
        number=number,
        kind=kind,
        executor=chance.choice(EXECUTORS),
        robot=chance.choice(ROBOTS) if kind == "drive" else "",
        at=round(chance.uniform(0.0, LENGTH / 2), 2),
        seconds=round(chance.uniform(0.5, 3.0), 2),
        waits=chance.random() < 0.7,
    )


def _fault(chance: random.Random, clients: int) -> Fault:
    what = chance.choice(FAULTS)
    match what:
        case "kill" | "freeze":
            who = chance.choice(PARTS)
        case "cut" | "slow":
            who = chance.choice(LINKS)
        case "kill_client":
            who = str(chance.randrange(clients))
        case "kill_run" | "kill_fork_server":
            who = chance.choice(EXECUTORS)
    at, seconds = chance.uniform(0.3, LENGTH), chance.choice((0.2, 0.6, 1.5, 4.0))
    return Fault(what, who, round(at, 2), seconds)

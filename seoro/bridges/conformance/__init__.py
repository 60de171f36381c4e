"""Conformance tests for backends of simulated robots, which check the contracts of `seoro.runtime`.

    import asyncio
    from seoro.bridges.conformance import check_backend

    def test_my_backend():
        asyncio.run(check_backend(open_my_backend))

The checks use a backend by its contracts only. Its world must be a free and level floor with a driving robot,
which starts at the origin and faces along x. `check_arm` requires a world with an arm. Rules are functions,
whose docstrings begin with the requirement.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from functools import partial

import anyio

from seoro.bridges.conformance import arms, bridge_arms, bridge_navigation, devices, robots, traffic, worlds
from seoro.bridges.conformance.arms import ArmBench, ArmFacts
from seoro.bridges.conformance.bench import RULES, Make, Rule, SimulatedBackend, has, started, started_with
from seoro.bridges.conformance.bridges import BridgeRule, HeldRobot
from seoro.bridges.conformance.levels import (
    BRIDGE_LEVELS,
    LEVELS,
    MOTIONS,
    checked_contracts,
    highest_level,
    rules_of,
    unsupported,
)
from seoro.errors import BackendError, BackendLost, BackendRefused
from seoro.runtime.contracts.robots import Arms

__all__ = [
    "ARM_RULES",
    "BRIDGE_LEVELS",
    "LEVELS",
    "MOTIONS",
    "RULES",
    "ArmFacts",
    "BridgeRule",
    "BrokenRule",
    "HeldRobot",
    "Make",
    "Rule",
    "SimulatedBackend",
    "advice",
    "bridge_arms",
    "bridge_navigation",
    "check_arm",
    "check_backend",
    "check_bridge_rule",
    "check_loss",
    "check_rule",
    "checked_contracts",
    "devices",
    "highest_level",
    "requirement",
    "robots",
    "rules_of",
    "traffic",
    "unsupported",
    "worlds",
]

LOSS_TIME = 10.0  # [s] of the machine's clock

ARM_RULES: tuple[Rule, ...] = tuple(
    value
    for name, value in vars(arms).items()
    if not name.startswith("_") and "arm" in getattr(value, "__annotations__", ())
)
"""Rules for arms with grippers."""


async def check_backend(make: Make) -> tuple[str, ...]:
    """Check a backend by all rules of its contracts.

    Unsupported contracts (`serves(contract)`) are not checked. Simulator nodes support a contract if their
    features include all of its verbs.

    Args:
        make: Opens the backend in the initial state of its world, always with the same seed. It is called several
            times, after the previous backend was closed.

    Returns:
        Names of the unsupported contracts, which were not checked.

    Raises:
        AssertionError: A rule is broken; the message has the rule, the observed and the expected value.
    """
    contracts = checked_contracts()
    try:
        async with make() as backend:
            missing = unsupported(backend, contracts)
    except BackendLost as error:
        raise AssertionError(f"A backend starts at time zero, with its robots at rest. But {error}") from error
    for rule in rules_of(set(contracts) - set(missing)):
        await check_rule(rule, make)
    return tuple(sorted(contract.__name__ for contract in missing))


async def check_arm(make: Make, facts: ArmFacts) -> None:
    """Check a backend with an arm by all rules for arms.

    Args:
        make: As for `check_backend`, with an arm in the world.
        facts: Facts about the arm, for the rules.

    Raises:
        AssertionError: The backend has no arm, or a rule is broken; the message has the observed value.
    """
    async with make() as backend:
        if not has(backend, Arms):
            raise AssertionError(f"{backend.name} does not support the contract `Arms`")
    for rule in ARM_RULES:
        await check_rule(rule, make, facts)


class BrokenRule(AssertionError):
    """A backend breaks a rule.

    Args:
        rule: The rule.
        fault: Observation that contradicts it.
    """

    def __init__(self, rule: Rule, fault: object) -> None:
        super().__init__(f"{requirement(rule)} But {fault}")
        self.fault = str(fault)


def requirement(rule: Rule) -> str:
    """Return the sentence that a rule checks."""
    return str(rule.__doc__).partition("\n")[0]


def advice(rule: Rule) -> str:
    """Return how to keep a rule, the second paragraph of its docstring; empty without one."""
    return " ".join(str(rule.__doc__).partition("\n\n")[2].split())


async def check_rule(rule: Rule, make: Make, facts: ArmFacts | None = None) -> None:
    """Check a backend by one rule.

    Args:
        rule: The rule.
        make: As for `check_backend`.
        facts: Facts about the arm, for rules of arms.

    Raises:
        BrokenRule: The rule is broken.
    """
    with _reporting(rule):
        if "make" in rule.__annotations__:
            await rule(make)
        elif facts is None:
            async with started(make) as bench:
                await rule(bench)
        else:
            async with started_with(make, arms.ARM, partial(ArmBench, facts)) as arm:
                await rule(arm)


async def check_bridge_rule(rule: BridgeRule, held: HeldRobot) -> None:
    """Check a bridge by one rule.

    Raises:
        BrokenRule: The rule is broken.
    """
    with _reporting(rule):
        await rule(held)


@contextmanager
def _reporting(rule: Rule) -> Iterator[None]:
    """Raise errors of the block as those of a broken rule."""
    try:
        yield
    except AssertionError as error:
        raise BrokenRule(rule, error) from error
    except BackendRefused as refused:
        raise BrokenRule(rule, f"a request is refused: {refused}") from refused
    except BackendLost as lost:
        raise BrokenRule(rule, lost) from lost


async def check_loss(make: Make, kill: Callable[[], None]) -> None:
    """Check that the end of the simulator is reported once, with a reason, and that later requests fail.

    Args:
        make: As for `check_backend`.
        kill: Kills the simulator at once.

    Raises:
        AssertionError: The end is not reported.
    """
    async with make() as backend:
        lost: list[str] = []
        reported = anyio.Event()

        def lose(error: BackendError) -> None:
            lost.append(str(error))
            reported.set()

        await backend.start_run(lambda name, arguments: None, lose)
        await backend.advance(0.1)
        kill()
        with anyio.move_on_after(LOSS_TIME):
            await reported.wait()
        if len(lost) != 1 or " " not in lost[0]:
            raise AssertionError(
                f"the end of {backend.name} must be reported once, in a sentence, but was reported as {lost}"
            )
        try:
            with anyio.fail_after(LOSS_TIME):
                await backend.advance(0.2)
        except BackendLost:
            return
        except TimeoutError:
            raise AssertionError(f"a grant waits for {backend.name}, which has ended") from None
        raise AssertionError(f"{backend.name} has ended, but a grant succeeded")

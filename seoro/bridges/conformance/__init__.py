"""Does a backend of simulated robots keep the contracts of `seoro.runtime`? For tests of ours and others'.

    import asyncio
    from seoro.bridges.conformance import check_backend

    def test_my_backend():
        asyncio.run(check_backend(open_my_backend))

It knows a backend by the contracts only, and asks it over whatever there is between them. The world has to be a
free and level floor about one robot that drives, which begins at the origin and looks along x. `check_arm` is for
a world with an arm. Rules are functions; the first line of a docstring is what has to hold.
"""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import ParamSpec

import anyio

from seoro.bridges.conformance import arms, cameras, entities, faults, passing, robots, snapshots
from seoro.bridges.conformance.arms import ArmFacts
from seoro.bridges.conformance.bench import Make, SimulatedBackend, has
from seoro.errors import BackendError, BackendLost, BackendRefused
from seoro.runtime.capabilities import (
    Arms,
    Cameras,
    DrivenRobots,
    Faults,
    MobileRobots,
    Sensors,
    Simulation,
    Snapshots,
)

__all__ = [
    "ARM_RULES",
    "RULES",
    "ArmFacts",
    "ArmRule",
    "Make",
    "Rule",
    "SimulatedBackend",
    "check_arm",
    "check_backend",
    "check_loss",
    "check_rule",
]

P = ParamSpec("P")
Rule = Callable[[Make], Awaitable[None]]
ArmRule = Callable[[Make, ArmFacts], Awaitable[None]]
LOSS_TIME = 10.0  # [s] of the machine's clock

RULES: tuple[tuple[tuple[type, ...], tuple[Rule, ...]], ...] = (
    ((), (passing.time_passes_in_grants, passing.time_never_goes_back)),
    (
        (DrivenRobots, Simulation),
        (
            passing.time_stands_still_without_grants,
            passing.requests_find_the_time_of_the_run,
            robots.robots_stand_still_after_a_run,
        ),
    ),
    ((DrivenRobots, Simulation), (robots.robots_drive_as_long_as_they_are_told,)),
    (
        (MobileRobots, DrivenRobots, Simulation),
        (
            passing.grants_end_when_something_is_to_be_told,
            robots.watches_fire_once,
            robots.cancelled_watches_are_silent,
        ),
    ),
    (
        (MobileRobots, Simulation),
        (
            passing.equal_runs_are_equal_to_the_bit,
            robots.goals_end_once,
            robots.cancelled_goals_end_and_robots_stop,
            entities.a_reset_puts_the_world_back,
        ),
    ),
    ((MobileRobots,), (robots.impossible_goals_are_refused, robots.watches_of_nothing_are_refused)),
    (
        (Simulation,),
        (
            entities.what_is_spawned_is_there_until_it_is_deleted,
            entities.names_are_unique,
            entities.what_cannot_be_spawned_is_refused,
            entities.what_is_put_somewhere_is_there,
        ),
    ),
    ((Simulation, DrivenRobots), (entities.contacts_are_told,)),
    (
        (Simulation, DrivenRobots, Snapshots),
        (snapshots.what_was_saved_goes_on_as_it_did, snapshots.unknown_snapshots_are_refused),
    ),
    (
        (Cameras,),
        (
            cameras.pictures_have_the_size_that_was_asked_for,
            cameras.what_stays_as_it_is_looks_the_same,
            cameras.cameras_are_there_until_they_are_deleted,
            cameras.unknown_cameras_are_refused,
        ),
    ),
    ((Cameras, Simulation), (cameras.cameras_see_what_changes,)),
    (
        (Faults, Sensors),
        (
            faults.faults_take_effect_until_they_are_cleared,
            faults.faults_that_cannot_be_found_are_given_up,
            faults.cancelled_faults_are_cleared,
            faults.impossible_faults_are_refused,
        ),
    ),
    ((Faults, DrivenRobots, Simulation), (faults.motors_without_power_do_not_drive,)),
)
"""The rules, each after the capabilities that a backend has to have for it to apply."""

ARM_RULES: tuple[ArmRule, ...] = (
    arms.arms_come_to_their_goals,
    arms.cancelled_motions_end_and_arms_stop,
    arms.impossible_motions_are_refused,
    arms.a_moving_arm_is_busy,
    arms.what_is_only_planned_moves_nothing,
    arms.grippers_open_and_close,
    arms.joints_are_watched,
)
"""The rules for arms with grippers."""


async def check_backend(make: Make) -> tuple[str, ...]:
    """Check a backend by all rules for what it can do.

    A backend that says by `serves(contract)` that it lacks a contract is not checked for that. Simulator nodes
    lack those of which they do not name all verbs among their features.

    Args:
        make: Opens the backend at the beginning of its world, always with the same seed; it is called several
            times, and one is closed before the next is opened.

    Returns:
        Names of the contracts that were not checked, since the backend lacks them.

    Raises:
        AssertionError: A rule is broken; the message says which, what was found, and what was expected.
    """
    try:
        async with make() as backend:
            lacks = {need for needs, _ in RULES for need in needs if not has(backend, need)}
    except BackendLost as error:
        raise AssertionError(f"A backend begins at time zero, with its robots at rest. But {error}") from error
    for needs, rules in RULES:
        if lacks.isdisjoint(needs):
            for rule in rules:
                await check_rule(rule, make)
    return tuple(sorted(need.__name__ for need in lacks))


async def check_arm(make: Make, facts: ArmFacts) -> None:
    """Check a backend that has an arm by all rules for arms.

    Args:
        make: As of `check_backend`; opens a world with an arm.
        facts: What the rules have to know of it.

    Raises:
        AssertionError: It has none, or a rule is broken; the message says which, and what was found.
    """
    async with make() as backend:
        if not has(backend, Arms):
            raise AssertionError(f"{backend.name} lacks what the contract `Arms` asks for")
    for rule in ARM_RULES:
        await check_rule(rule, make, facts)


async def check_rule(rule: Callable[P, Awaitable[None]], *of: P.args, **named: P.kwargs) -> None:
    """Check a backend by one of the rules, with what that takes.

    Raises:
        AssertionError: The rule is broken.
    """
    demand = str(rule.__doc__).partition("\n")[0]
    try:
        await rule(*of, **named)
    except AssertionError as error:
        raise AssertionError(f"{demand} But {error}") from error
    except BackendRefused as refused:
        raise AssertionError(f"{demand} But a request is refused: {refused}") from refused
    except BackendLost as lost:
        raise AssertionError(f"{demand} But {lost}") from lost


async def check_loss(make: Make, kill: Callable[[], None]) -> None:
    """Check that the end of what simulates is told: once, with a reason, and that requests fail from then on.

    Args:
        make: As of `check_backend`.
        kill: Ends what simulates, at once and without a word.

    Raises:
        AssertionError: It is not told.
    """
    async with make() as backend:
        lost: list[str] = []
        told = anyio.Event()

        def lose(error: BackendError) -> None:
            lost.append(str(error))
            told.set()

        await backend.start_run(lambda name, arguments: None, lose)
        await backend.advance(0.1)
        kill()
        with anyio.move_on_after(LOSS_TIME):
            await told.wait()
        if len(lost) != 1 or " " not in lost[0]:
            raise AssertionError(f"the end of {backend.name} is told once, in a sentence, but was told as {lost}")
        try:
            with anyio.fail_after(LOSS_TIME):
                await backend.advance(0.2)
        except BackendLost:
            return
        except TimeoutError:
            raise AssertionError(f"{backend.name} is gone, and a grant waits for it") from None
        raise AssertionError(f"{backend.name} is gone, and a grant was carried out")

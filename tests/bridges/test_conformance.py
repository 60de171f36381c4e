"""Conformance of simulator nodes, and of backends that break a rule."""

from __future__ import annotations

import asyncio
import os
import signal
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from itertools import count
from pathlib import Path
from typing import Any

import pytest

from seoro.bridges import conformance
from seoro.bridges.conformance import (
    ARM_RULES,
    RULES,
    ArmFacts,
    Rule,
    check_arm,
    check_backend,
    check_loss,
    robots,
    worlds,
)
from seoro.bridges.conformance.bench import Make
from seoro.bridges.launch import start_simulator
from seoro.bridges.sim.node import SimulatorNode
from seoro.bridges.sim.requests import REQUEST_TIMEOUT
from seoro.errors import BackendRefused
from seoro.robotics.geometry import Pose3D
from seoro.runtime.contracts.backends import LossHandler, Report, Reporter
from tests.bridges.nodes import OPTIONS, Connect, running
from tests.bridges.spoiling import Spoil, do_nothing, expect_broken, replace_method, spoiled
from tests.integration.conftest import children


@pytest.fixture
def make(mujoco: Connect) -> Make:
    return mujoco(OPTIONS)


@pytest.mark.more
async def test_mujoco_fulfils_the_contracts(make: Make) -> None:
    await check_backend(make)


@pytest.mark.more
async def test_pybullet_fulfils_the_contracts(tmp_path: Path) -> None:
    pytest.importorskip("pybullet", reason="the engine pybullet is not installed")
    with running("pybullet", tmp_path) as making:
        await check_backend(making)


async def test_a_world_without_an_arm_fails_the_arm_check(make: Make) -> None:
    with pytest.raises(AssertionError, match="has no robot for an actor of type arm"):
        await check_arm(make, ArmFacts(("joint",), ((0.0,), (1.0,)), 0.1))


@pytest.mark.more
@pytest.mark.engine("mujoco")
async def test_the_death_of_a_node_is_reported() -> None:
    others = children(os.getpid())

    def kill() -> None:
        for pid in children(os.getpid()):
            if pid not in others:
                os.kill(pid, signal.SIGKILL)

    await check_loss(lambda: start_simulator("mujoco", OPTIONS), kill)


async def test_an_unreported_end_of_a_node_is_detected(monkeypatch: pytest.MonkeyPatch, make: Make) -> None:
    monkeypatch.setattr(conformance, "LOSS_TIME", 0.05)
    with pytest.raises(AssertionError, match=r"must be reported once, in a sentence, but was reported as \[\]"):
        await check_loss(make, lambda: None)


def test_each_rule_has_a_sentence() -> None:
    for rule in (*RULES, *ARM_RULES):
        assert str(rule.__doc__).partition("\n")[0].endswith("."), rule


# ---------------------------------------------------------------- backends with a fault

DRAWS = count(1)


def deaf(node: SimulatorNode) -> None:
    """Report nothing."""
    advance = node.advance

    async def spoiled(until: float) -> float:
        node._reporters.clear()
        return await advance(until)

    replace_method(node, advance=spoiled)


def stuttering(node: SimulatorNode) -> None:
    """Report everything twice."""

    class Twice(dict[str, Reporter]):
        def __setitem__(self, key: str, report: Reporter) -> None:
            def twice(answered: Report) -> None:
                report(answered)
                report(answered)

            super().__setitem__(key, twice)

    node._reporters = Twice()


def late(node: SimulatorNode) -> None:
    """Report after the grant."""

    class Late(dict[str, Reporter]):
        def __setitem__(self, key: str, report: Reporter) -> None:
            def later(answered: Report) -> None:
                asyncio.get_running_loop().call_later(0.05, report, answered)

            super().__setitem__(key, later)

    node._reporters = Late()


def hasty(node: SimulatorNode) -> None:
    """Simulate beyond the grant."""
    advance = node.advance
    replace_method(node, advance=lambda until: advance(until + 0.1))


def forgetful(node: SimulatorNode) -> None:
    """Its time goes back."""
    advance = node.advance

    async def spoiled(until: float) -> float:
        return min(until, await advance(until))

    replace_method(node, advance=spoiled)


def restless(node: SimulatorNode) -> None:
    """Time passes while it is asked for poses."""
    ask = node.relative_pose

    async def spoiled(frame: str, parent_frame: str, distance: float) -> Pose3D:
        pose = await ask(frame, parent_frame, distance)
        await node.step_simulation(1)
        return pose

    replace_method(node, relative_pose=spoiled)


def prescient(node: SimulatorNode) -> None:
    """Keep the simulation ahead of the grant."""
    ask = node.ask

    async def spoiled(verb: Any, request: Any, timeout: float = REQUEST_TIMEOUT) -> Any:
        node._back = None
        return await ask(verb, request, timeout)

    replace_method(node, ask=spoiled)


def noisy(node: SimulatorNode) -> None:
    """Its poses have noise without a seed."""
    ask = node.relative_pose

    async def spoiled(frame: str, parent_frame: str, distance: float) -> Pose3D:
        pose = await ask(frame, parent_frame, distance)
        return replace(pose, position=replace(pose.position, x=pose.position.x + 1e-12 * next(DRAWS)))

    replace_method(node, relative_pose=spoiled)


def stubborn(node: SimulatorNode) -> None:
    """Ignore cancellations of goals."""
    replace_method(node, cancel_goal=do_nothing)


def touchy(node: SimulatorNode) -> None:
    """Refuse cancellations of ended watches."""

    async def spoiled(watch: str) -> None:
        raise BackendRefused(f"unknown watch {watch}", 2)

    replace_method(node, cancel_watch=spoiled)


def persistent(node: SimulatorNode) -> None:
    """Ignore cancellations of watches."""
    replace_method(node, cancel_watch=do_nothing)


def credulous(node: SimulatorNode) -> None:
    """Accept every goal, and abort it later."""
    navigate = node.navigate

    async def spoiled(robot: str, poses: Sequence[Pose3D], *, stop_at_each: bool, report: Reporter) -> str:
        try:
            return await navigate(robot, poses, stop_at_each=stop_at_each, report=report)
        except BackendRefused:
            return "taken"

    replace_method(node, navigate=spoiled)


def curt(node: SimulatorNode) -> None:
    """Refuse with one word."""
    delete = node.delete_entity

    async def spoiled(name: str) -> None:
        try:
            await delete(name)
        except BackendRefused as refused:
            raise BackendRefused("no", refused.code) from None

    replace_method(node, delete_entity=spoiled)


def hoarding(node: SimulatorNode) -> None:
    """Delete nothing."""
    replace_method(node, delete_entity=do_nothing)


def accommodating(node: SimulatorNode) -> None:
    """Rename without permission."""
    spawn = node.spawn_entity

    async def spoiled(name: str, model: str, pose: Pose3D, *, allow_renaming: bool = False) -> str:
        return await spawn(name, model, pose, allow_renaming=True)

    replace_method(node, spawn_entity=spoiled)


def sticky(node: SimulatorNode) -> None:
    """A reset deletes nothing."""
    replace_method(node, reset_simulation=do_nothing)


def unattended(node: SimulatorNode) -> None:
    """Its robots drive on after the run."""
    replace_method(node, end_run=do_nothing)


def discreet(node: SimulatorNode) -> None:
    """Report no contacts."""
    start = node.start_run

    async def spoiled(on_event: Callable[[str, Mapping[str, Any]], None], on_lost: LossHandler) -> None:
        await start(lambda name, arguments: None, on_lost)

    replace_method(node, start_run=spoiled)


def amnesic(node: SimulatorNode) -> None:
    """Restore nothing."""
    replace_method(node, restore_snapshot=do_nothing)


@pytest.mark.parametrize(
    ("spoil", "rule", "words"),
    [
        pytest.param(deaf, robots.goals_end_once, "reported as nothing", marks=pytest.mark.more),
        (deaf, robots.grants_end_at_events, "its fired watch had 0 reports"),
        (stuttering, robots.drives_have_their_speed_and_duration, "succeeded, succeeded"),
        (late, robots.grants_end_at_events, "its fired watch had 0 reports"),
        (hasty, robots.time_passes_in_grants, "a grant from 0.0 s to 0.02 s reached 0.12"),
        (forgetful, robots.time_never_goes_back, "at 1.0 s, a grant to 0.5 s reached 0.5 s"),
        (restless, robots.time_stands_still_without_grants, "without a grant"),
        (prescient, robots.requests_apply_at_the_time_of_the_run, "after small grants"),
        pytest.param(noisy, robots.equal_runs_are_reproducible, "in a second run", marks=pytest.mark.more),
        pytest.param(
            stubborn, robots.cancelled_goals_end_and_robots_stop, "cancelled 1 s ago moved", marks=pytest.mark.more
        ),
        (touchy, robots.watches_fire_once, "a request is refused: unknown watch"),
        (persistent, robots.cancelled_watches_are_silent, "reported as succeeded"),
        (credulous, robots.impossible_goals_are_refused, "without an initial pose is not refused"),
        (curt, worlds.invalid_spawns_are_refused, "'no', which is not a sentence"),
        (hoarding, worlds.spawned_entities_are_listed_until_deleted, "still listed"),
        (accommodating, worlds.names_are_unique, "a second entity with the same name is not refused"),
        pytest.param(
            sticky, worlds.resets_restore_the_world, "after a reset the robot is at", marks=pytest.mark.more
        ),
        (unattended, robots.robots_stand_still_after_a_run, "a robot whose run ended 1 s ago moved"),
        (discreet, worlds.contacts_are_reported, "no contact was reported"),
        (amnesic, worlds.restored_runs_repeat_the_original, "a restored robot is at"),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
async def test_backends_with_a_fault_break_a_rule(make: Make, spoil: Spoil, rule: Rule, words: str) -> None:
    await expect_broken(rule, words, spoiled(make, spoil))

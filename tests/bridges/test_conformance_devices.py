"""The rules for cameras and for faults of sensors and motors find backends that break them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import count

import pytest

from seoro.bridges.conformance import Make, Rule, cameras, check_rule, faults
from seoro.bridges.sim.node import SimulatorNode
from seoro.bridges.wire import Result
from seoro.errors import BackendRefused
from seoro.runtime.capabilities import Image
from seoro.runtime.contracts import Pose3D, Report, Reporter
from seoro.runtime.device_faults import Fault, PowerLoss
from tests.bridges.nodes import OPTIONS, Connect
from tests.bridges.spoiling import Spoil, do_nothing, expect_broken, replace_method, spoiled
from tests.sim_nodes.engines import needs_pictures


@pytest.fixture
def make(mujoco: Connect) -> Make:
    needs_pictures("mujoco")
    return mujoco(OPTIONS)


def _pictures(change: Callable[[Image], Image]) -> Spoil:
    """Spoil pictures."""

    def spoil(node: SimulatorNode) -> None:
        take = node.take_picture

        async def spoiled(name: str) -> Image:
            return change(await take(name))

        replace_method(node, take_picture=spoiled)

    return spoil


DRAWS = count(1)
small = _pictures(lambda image: replace(image, width=image.width // 2))
raw = _pictures(lambda image: replace(image, png=image.png[8:]))
grainy = _pictures(lambda image: replace(image, png=image.png + bytes([next(DRAWS)])))
stale = _pictures(lambda image: replace(image, time=image.time - 0.1))
seen: dict[str, Image] = {}
frozen = _pictures(lambda image: seen.setdefault("first", image))


def heavy(node: SimulatorNode) -> None:
    """Its cameras stay where they are."""
    replace_method(node, place_camera=do_nothing)


def hoarding(node: SimulatorNode) -> None:
    """It deletes no cameras."""
    replace_method(node, delete_camera=do_nothing)


def doubling(node: SimulatorNode) -> None:
    """It takes a second camera of a name for the first."""
    spawn = node.spawn_camera

    async def spoiled(name: str, pose: Pose3D, fov: float, width: int, height: int) -> str:
        if name in await node.cameras():
            return name
        return await spawn(name, pose, fov, width, height)

    replace_method(node, spawn_camera=spoiled)


def imaginative(node: SimulatorNode) -> None:
    """It aims cameras that there are not."""
    replace_method(node, aim_camera=do_nothing)


def blind(node: SimulatorNode) -> None:
    """It refuses every picture as if it had gone wrong."""

    async def spoiled(name: str) -> Image:
        raise BackendRefused("there is no light today", Result.OPERATION_FAILED)

    replace_method(node, take_picture=spoiled)


def tough(node: SimulatorNode) -> None:
    """Its faults have no effect, and it says that they have."""

    async def spoiled(robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        def confirm(told: Report) -> None:
            report(replace(told, message="it is silent"))

        return await node.watch_sample(robot, "lidar", confirm)

    replace_method(node, inject_fault=spoiled)


def wordless(node: SimulatorNode) -> None:
    """It does not say what it has measured."""
    inject = node.inject_fault

    async def spoiled(robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        def quietly(told: Report) -> None:
            report(replace(told, message=""))

        return await inject(robot, device, fault, limit, quietly)

    replace_method(node, inject_fault=spoiled)


def scarred(node: SimulatorNode) -> None:
    """Its faults last."""
    replace_method(node, clear_faults=do_nothing)


def stubborn(node: SimulatorNode) -> None:
    """It cancels no faults."""
    replace_method(node, cancel_fault=do_nothing)


def overzealous(node: SimulatorNode) -> None:
    """It clears all faults where a measurement is cancelled, whether that has ended or not."""

    async def spoiled(measurement: str) -> None:
        await node.clear_faults("turtlebot4", "")

    replace_method(node, cancel_fault=spoiled)


def patient(node: SimulatorNode) -> None:
    """It measures for as long as it takes."""
    inject = node.inject_fault

    async def spoiled(robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        return await inject(robot, device, fault, 60.0, report)

    replace_method(node, inject_fault=spoiled)


def coasting(node: SimulatorNode) -> None:
    """Motors without power drive on, since it is another fault that they get."""
    inject = node.inject_fault

    async def spoiled(robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        return await inject(robot, "lidar", PowerLoss(), limit, report)

    replace_method(node, inject_fault=spoiled)


@pytest.mark.parametrize(
    ("spoil", "rule", "words"),
    [
        (small, cameras.pictures_have_the_size_that_was_asked_for, "(96, 64) pixels is said to have (48, 64)"),
        (raw, cameras.pictures_have_the_size_that_was_asked_for, "is no PNG"),
        (stale, cameras.pictures_have_the_size_that_was_asked_for, "s says"),
        (blind, cameras.pictures_have_the_size_that_was_asked_for, "is refused with code 4: there is no light"),
        (grainy, cameras.what_stays_as_it_is_looks_the_same, "although nothing has happened"),
        (frozen, cameras.cameras_see_what_changes, "sees the same when a box was spawned before it as first"),
        (heavy, cameras.cameras_see_what_changes, "sees the same where it was put as when a box was spawned"),
        (hoarding, cameras.cameras_are_there_until_they_are_deleted, "a camera that was deleted is still listed"),
        (doubling, cameras.cameras_are_there_until_they_are_deleted, "a second camera of a name is not refused"),
        (imaginative, cameras.unknown_cameras_are_refused, "to aim an unknown camera is not refused"),
        (tough, faults.faults_take_effect_until_they_are_cleared, "has no power, and sends samples"),
        (wordless, faults.faults_take_effect_until_they_are_cleared, "reported as '', which is no sentence"),
        (scarred, faults.faults_take_effect_until_they_are_cleared, "were cleared, and it sends nothing"),
        (patient, faults.faults_that_cannot_be_found_are_given_up, "not once as aborted"),
        (stubborn, faults.cancelled_faults_are_cleared, "was cancelled, and is still there"),
        (overzealous, faults.cancelled_faults_are_cleared, "a fault is gone, since"),
        (tough, faults.impossible_faults_are_refused, "a fault of an unknown device is not refused"),
        (coasting, faults.motors_without_power_do_not_drive, "a robot without power that is driven"),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
async def test_backends_with_a_fault_break_a_rule(make: Make, spoil: Spoil, rule: Rule, words: str) -> None:
    await expect_broken(rule, words, spoiled(make, spoil))


async def test_a_backend_that_cannot_draw_keeps_the_rules_of_pictures(make: Make) -> None:
    async def undrawn(name: str) -> Image:
        raise BackendRefused("no picture can be taken: there is no screen", Result.FEATURE_UNSUPPORTED)

    cannot_draw = spoiled(make, lambda node: replace_method(node, take_picture=undrawn))
    await check_rule(cameras.pictures_have_the_size_that_was_asked_for, cannot_draw)
    await check_rule(cameras.cameras_see_what_changes, cannot_draw)

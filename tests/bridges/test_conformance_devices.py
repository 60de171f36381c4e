"""Rules for cameras and for faults of sensors and motors, with backends that break them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from itertools import count

import pytest

from seoro.bridges.conformance import Make, Rule, check_rule, devices
from seoro.bridges.sim.node import SimulatorNode
from seoro.bridges.wire import Result
from seoro.errors import BackendRefused
from seoro.robotics.faults import Fault, PowerLoss
from seoro.robotics.geometry import Pose3D
from seoro.runtime.contracts.backends import Report, Reporter
from seoro.runtime.contracts.sensors import Image
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
    """Delete no cameras."""
    replace_method(node, delete_camera=do_nothing)


def doubling(node: SimulatorNode) -> None:
    """Accept a second camera with the same name."""
    spawn = node.spawn_camera

    async def spoiled(name: str, pose: Pose3D, fov: float, width: int, height: int) -> str:
        if name in await node.cameras():
            return name
        return await spawn(name, pose, fov, width, height)

    replace_method(node, spawn_camera=spoiled)


def imaginative(node: SimulatorNode) -> None:
    """Accept the aiming of unknown cameras."""
    replace_method(node, aim_camera=do_nothing)


def blind(node: SimulatorNode) -> None:
    """Refuse every picture with a wrong code."""

    async def spoiled(name: str) -> Image:
        raise BackendRefused("the light is off", Result.OPERATION_FAILED)

    replace_method(node, take_picture=spoiled)


def tough(node: SimulatorNode) -> None:
    """Report effects of faults without any."""

    async def spoiled(robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        def confirm(answered: Report) -> None:
            report(replace(answered, message="it is silent"))

        return await node.watch_sample(robot, "lidar", confirm)

    replace_method(node, inject_fault=spoiled)


def wordless(node: SimulatorNode) -> None:
    """Report effects without a message."""
    inject = node.inject_fault

    async def spoiled(robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        def quietly(answered: Report) -> None:
            report(replace(answered, message=""))

        return await inject(robot, device, fault, limit, quietly)

    replace_method(node, inject_fault=spoiled)


def scarred(node: SimulatorNode) -> None:
    """Its faults last."""
    replace_method(node, clear_faults=do_nothing)


def stubborn(node: SimulatorNode) -> None:
    """Ignore cancellations of faults."""
    replace_method(node, cancel_fault=do_nothing)


def overzealous(node: SimulatorNode) -> None:
    """Clear faults at each cancellation of a measurement."""

    async def spoiled(measurement: str) -> None:
        await node.clear_faults("turtlebot4", "")

    replace_method(node, cancel_fault=spoiled)


def patient(node: SimulatorNode) -> None:
    """Measure without a time limit."""
    inject = node.inject_fault

    async def spoiled(robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        return await inject(robot, device, fault, 60.0, report)

    replace_method(node, inject_fault=spoiled)


def coasting(node: SimulatorNode) -> None:
    """Motors without power drive on, since they have another fault."""
    inject = node.inject_fault

    async def spoiled(robot: str, device: str, fault: Fault, limit: float, report: Reporter) -> str:
        return await inject(robot, "lidar", PowerLoss(), limit, report)

    replace_method(node, inject_fault=spoiled)


@pytest.mark.parametrize(
    ("spoil", "rule", "words"),
    [
        (small, devices.pictures_have_the_requested_size, "(96, 64) pixels is reported with (48, 64)"),
        (raw, devices.pictures_have_the_requested_size, "an invalid PNG"),
        (stale, devices.pictures_have_the_requested_size, "s has the time"),
        (blind, devices.pictures_have_the_requested_size, "is refused with code 4: the light is off"),
        (grainy, devices.pictures_are_reproducible, "although nothing has changed"),
        (frozen, devices.cameras_see_changes, "has the same picture after a spawn in its view as first"),
        (heavy, devices.cameras_see_changes, "has the same picture after a move as after a spawn"),
        (hoarding, devices.cameras_are_listed_until_deleted, "a deleted camera is still listed"),
        (doubling, devices.cameras_are_listed_until_deleted, "a second camera with the same name is not refused"),
        (imaginative, devices.unknown_cameras_are_refused, "the aiming of an unknown camera is not refused"),
        (tough, devices.faults_take_effect_until_they_are_cleared, "has no power, but sends samples"),
        (wordless, devices.faults_take_effect_until_they_are_cleared, "reported as '', which is not a sentence"),
        (scarred, devices.faults_take_effect_until_they_are_cleared, "were cleared, but it sends nothing"),
        (patient, devices.faults_without_effect_are_aborted, "not once as aborted"),
        (stubborn, devices.cancelled_faults_are_cleared, "a cancelled fault of"),
        (overzealous, devices.cancelled_faults_are_cleared, "a fault was cleared by a cancellation"),
        (tough, devices.impossible_faults_are_refused, "a fault of an unknown device is not refused"),
        (coasting, devices.motors_without_power_do_not_drive, "a robot without power that is driven"),
    ],
    ids=lambda value: getattr(value, "__name__", None),
)
async def test_backends_with_a_fault_break_a_rule(make: Make, spoil: Spoil, rule: Rule, words: str) -> None:
    await expect_broken(rule, words, spoiled(make, spoil))


async def test_a_backend_without_pictures_fulfils_the_rules_of_pictures(make: Make) -> None:
    async def undrawn(name: str) -> Image:
        raise BackendRefused("cannot take a picture: missing screen", Result.FEATURE_UNSUPPORTED)

    cannot_draw = spoiled(make, lambda node: replace_method(node, take_picture=undrawn))
    await check_rule(devices.pictures_have_the_requested_size, cannot_draw)
    await check_rule(devices.cameras_see_changes, cannot_draw)

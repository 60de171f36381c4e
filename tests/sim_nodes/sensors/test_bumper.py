from __future__ import annotations

import math

import pytest

from sim_nodes.geometry import quaternion
from sim_nodes.physics import BodyState, ContactPoint
from sim_nodes.robots.reading import load_robot
from sim_nodes.sensors.base import RELEASE_TICKS, Bump, Bumper

PLACE = BodyState((2.0, 1.0, 0.0), quaternion(0.0, 0.0, math.pi / 2))  # it looks along the map's y axis


def bumper() -> Bumper:
    base = load_robot("turtlebot4").mobile
    assert base is not None
    assert base.bumper is not None
    return Bumper(base.bumper, lambda: PLACE)


def point(bearing: float, height: float = 0.05, entity: str = "box") -> ContactPoint:
    """Return a point of the robot's rim at a bearing [rad] from straight ahead, to the left."""
    angle = bearing + math.pi / 2
    outward = (math.cos(angle), math.sin(angle), 0.0)
    return ContactPoint(entity, (2.0 + 0.164 * outward[0], 1.0 + 0.164 * outward[1], height), outward)


@pytest.mark.parametrize(
    ("degrees", "zone"),
    [
        (0, "bump_front_center"),
        (40, "bump_front_left"),
        (80, "bump_left"),
        (-40, "bump_front_right"),
        (-89, "bump_right"),
    ],
)
def test_zones_cover_the_front(degrees: float, zone: str) -> None:
    pressed = bumper()
    pressed.touch([point(math.radians(degrees))], 5)
    assert pressed.read(5).bumps == (Bump(zone, "box", 5),)


@pytest.mark.parametrize("touched", [point(math.pi), point(math.radians(100)), point(0.0, height=0.2)])
def test_contacts_behind_and_above_do_not_press_a_bumper(touched: ContactPoint) -> None:
    pressed = bumper()
    pressed.touch([touched], 5)
    assert pressed.read(5).bumps == ()


def test_a_short_touch_between_samples_presses_and_releases() -> None:
    pressed = bumper()
    pressed.touch([point(0.0)], 5)
    assert pressed.read(5 + RELEASE_TICKS).bumps == (Bump("bump_front_center", "box", 5),)
    assert pressed.read(6 + RELEASE_TICKS).bumps == ()


def test_rattling_counts_as_one_press() -> None:
    pressed = bumper()
    for tick in (5, 8, 11):
        pressed.touch([point(0.0)], tick)
    assert pressed.read(12).bumps == (Bump("bump_front_center", "box", 5),)
    pressed.touch([point(0.0)], 12 + 2 * RELEASE_TICKS)
    assert pressed.read(12 + 2 * RELEASE_TICKS).bumps[0].since == 12 + 2 * RELEASE_TICKS


def test_several_entities_press_several_zones() -> None:
    pressed = bumper()
    pressed.touch([point(1.2, entity="wall"), point(0.0), point(0.1)], 1)
    assert pressed.read(1).bumps == (Bump("bump_front_center", "box", 1), Bump("bump_left", "wall", 1))

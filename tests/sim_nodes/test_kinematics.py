"""Kinematics of drives, and footprints."""

from __future__ import annotations

import math

import numpy as np
import pytest
from pydantic import ValidationError

from sim_nodes.check.bench import BASE
from sim_nodes.check.drives import HALF_TRACK, RADIUS, WHEELBASE, drive_of
from sim_nodes.robots.declaration import MobileDeclaration
from sim_nodes.robots.drive_declaration import DriveKind
from sim_nodes.robots.footprint import MAX_CORNERS, Footprint, convex_footprint
from sim_nodes.robots.kinematics import Velocity, base_motion, motor_commands, motor_joints

SQUARE = [[0.2, -0.1], [0.2, 0.1], [-0.2, 0.1], [-0.2, -0.1]]


@pytest.mark.parametrize(
    ("kind", "velocity"),
    [
        (DriveKind.SKID_STEER, Velocity(0.3, -0.4)),
        (DriveKind.OMNIDIRECTIONAL, Velocity(0.3, -0.4, 0.2)),
        (DriveKind.OMNIDIRECTIONAL, Velocity(0.0, 0.0, -0.2)),
        (DriveKind.ACKERMANN, Velocity(0.4, 0.5)),
        (DriveKind.ACKERMANN, Velocity(-0.4, 0.5)),
        (DriveKind.ACKERMANN, Velocity(0.4, 0.0)),
    ],
)
def test_motors_and_base_motion_are_inverse(kind: DriveKind, velocity: Velocity) -> None:
    drive = drive_of(kind)
    commands = motor_commands(drive, velocity)
    assert len(commands) == len(motor_joints(drive))
    assert base_motion(drive, commands) == pytest.approx(velocity)


def test_mecanum_wheels_turn_in_pairs_sideways() -> None:
    front_left, front_right, rear_left, rear_right = motor_commands(
        drive_of(DriveKind.OMNIDIRECTIONAL), Velocity(0.0, 0.0, 0.3)
    )
    # To the left, the front left wheel turns back and the rear left one ahead.
    assert (front_left, front_right, rear_left, rear_right) == pytest.approx((-3.0, 3.0, 3.0, -3.0))


def test_steered_wheels_roll_around_one_centre() -> None:
    radius = 1.0
    commands = motor_commands(drive_of(DriveKind.ACKERMANN), Velocity(0.5, 0.5 / radius))
    left, right = commands[4:]
    assert math.tan(left) == pytest.approx(WHEELBASE / (radius - HALF_TRACK))
    assert math.tan(right) == pytest.approx(WHEELBASE / (radius + HALF_TRACK))
    assert commands[0] * RADIUS == pytest.approx(0.5 * math.hypot(radius - HALF_TRACK, WHEELBASE))


def test_a_footprint_is_a_convex_polygon() -> None:
    declared = BASE.model_dump() | {"footprint": SQUARE}
    footprint = MobileDeclaration.model_validate(declared).footprint
    assert footprint == Footprint(((0.2, -0.1), (0.2, 0.1), (-0.2, 0.1), (-0.2, -0.1)))
    assert footprint.points.shape == (4, 2)
    assert (footprint.radius, footprint.inner_radius) == pytest.approx((math.hypot(0.2, 0.1), 0.1))
    assert BASE.footprint is None


@pytest.mark.parametrize(
    ("footprint", "words"),
    [
        (SQUARE[:2], "at least 3 items"),
        (SQUARE[::-1], "counterclockwise"),
        ([SQUARE[0], SQUARE[2], SQUARE[1], SQUARE[3]], "convex"),
        ([*SQUARE, *SQUARE], "convex"),
        ([[math.nan, 0.0], *SQUARE], "finite"),
    ],
)
def test_an_invalid_footprint_is_refused(footprint: list[list[float]], words: str) -> None:
    with pytest.raises(ValidationError, match=words):
        MobileDeclaration.model_validate(BASE.model_dump() | {"footprint": footprint})


def test_a_round_outline_has_few_corners_and_contains_all_points() -> None:
    angles = np.linspace(0.0, 2.0 * math.pi, 200)
    points = 0.3 * np.column_stack([np.cos(angles), np.sin(angles)])
    footprint = convex_footprint(points)
    assert len(footprint.corners) == MAX_CORNERS
    assert 0.299 <= footprint.inner_radius <= footprint.radius <= 0.315
    with pytest.raises(ValueError, match="no area"):
        convex_footprint(points * [1.0, 0.0])


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"kind": "ackermann"}, "min_turning_radius"),
        ({"kind": "skid_steer", "max_lateral_speed": 1.0}, "max_lateral_speed"),
        ({"kind": "hover"}, "kind"),
        ({"wheels": []}, "at least 2"),
    ],
)
def test_an_inconsistent_drive_is_refused(change: dict[str, object], words: str) -> None:
    drive = drive_of(DriveKind.SKID_STEER).model_dump() | change
    with pytest.raises(ValidationError, match=words):
        MobileDeclaration.model_validate(BASE.model_dump() | {"drive": drive})

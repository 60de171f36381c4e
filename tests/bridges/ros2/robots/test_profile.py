"""Profiles of robots: bundled profiles, and files of users."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges.ros2.robots.profile import Limits, available_profiles, read_profile
from seoro.errors import UsageError

BASE = "model: rover\nkinds: [robot]\nbase:\n  limits: {linear: 1, angular: 5e-1}\n"
GRIPPER = (
    "model: rover\nkinds: [arm]\narm:\n  joints: {{a: 1}}\n  trajectory: follow\n"
    "  gripper: {{action: grip, joint: f, closed: {closed}, per_metre: {per_metre}, widest: 1, force: 1}}\n"
)


@pytest.mark.parametrize("name", available_profiles())
def test_bundled_profiles_are_valid(name: str) -> None:
    assert read_profile(name).model == name


def test_a_profile_of_the_user_has_the_default_names(tmp_path: Path) -> None:
    file = tmp_path / "rover.yaml"
    file.write_text(f"{BASE}  odometry: /wheels\n")
    base = read_profile(str(file)).base
    assert base is not None
    assert (base.cmd_vel, base.odometry, base.limits) == ("cmd_vel", "/wheels", Limits(linear=1.0, angular=0.5))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("model: rover\nkinds: [robot]\n", r"rover\.yaml:1: the file: .* expected a base, an arm, or both"),
        ("model: rover\nkinds: []\n", r"rover\.yaml:2: kinds: "),
        ("model: rover\nkind: robot\n", r"rover\.yaml:2: kind: unknown key"),
        ("model: [", r"rover\.yaml:\d: invalid YAML"),
        (BASE + "  cmd_vel: a\n  cmd_vel: b\n", r"rover\.yaml:6: .* 'cmd_vel', .* line 5"),
        (BASE + "  cmd_vel: a//b\n", r"rover\.yaml:5: base\.cmd_vel: .* empty part between"),
        (BASE + "  odometry: odom/\n", r"rover\.yaml:5: base\.odometry: .* empty part between or after"),
        (BASE + "  odometry: ~/odom\n", r"rover\.yaml:5: base\.odometry: .* private names are unsupported"),
        (BASE.replace("1,", "true,"), r"rover\.yaml:4: base\.limits\.linear: .* valid number"),
        (GRIPPER.format(closed=".nan", per_metre=1), r"rover\.yaml:6: arm\.gripper\.closed: .* finite"),
        (GRIPPER.format(closed=0, per_metre=".inf"), r"rover\.yaml:6: arm\.gripper\.per_metre: .* finite"),
        (GRIPPER.format(closed=0, per_metre=0), r"rover\.yaml:6: arm\.gripper\.per_metre: .* not be 0"),
    ],
)
def test_invalid_profiles_are_reported_with_the_line(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "rover.yaml"
    file.write_text(text)
    with pytest.raises(UsageError, match=words):
        read_profile(str(file))


def test_unknown_profiles_are_refused_with_the_known_ones() -> None:
    with pytest.raises(UsageError, match="unknown profile 'rover'") as refused:
        read_profile("rover")
    assert "turtlebot4" in refused.value.help

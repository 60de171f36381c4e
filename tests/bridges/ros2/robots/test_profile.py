"""Profiles of robots: those that come with seoro, and those of users."""

from __future__ import annotations

from pathlib import Path

import pytest

from seoro.bridges.ros2.robots.profile import available_profiles, read_profile
from seoro.errors import InvalidUse


@pytest.mark.parametrize("name", available_profiles())
def test_the_profiles_that_come_with_seoro_are_right(name: str) -> None:
    assert read_profile(name).model == name


def test_a_profile_of_ones_own_has_the_usual_names(tmp_path: Path) -> None:
    file = tmp_path / "rover.yaml"
    file.write_text(
        "model: rover\nkinds: [robot]\nbase:\n  limits: {linear: 1, angular: 1}\n  odometry: /wheels\n"
    )
    base = read_profile(str(file)).base
    assert base is not None
    assert (base.cmd_vel, base.odometry, base.limits.linear) == ("cmd_vel", "/wheels", 1.0)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("model: rover\nkinds: [robot]\n", r"rover\.yaml:1: the file: .* a robot has a base, or an arm, or both"),
        ("model: rover\nkinds: []\n", r"rover\.yaml:2: kinds: "),
        ("model: rover\nkind: robot\n", r"rover\.yaml:2: kind: Extra inputs"),
        ("model: [", r"rover\.yaml:\d: no valid YAML"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path: Path, text: str, words: str) -> None:
    file = tmp_path / "rover.yaml"
    file.write_text(text)
    with pytest.raises(InvalidUse, match=words):
        read_profile(str(file))


def test_unknown_profiles_are_told_the_known_ones() -> None:
    with pytest.raises(InvalidUse, match="there is no profile 'rover'") as refused:
        read_profile("rover")
    assert "turtlebot4" in refused.value.help

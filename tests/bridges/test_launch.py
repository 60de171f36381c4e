from __future__ import annotations

import sys
from importlib.machinery import ModuleSpec

import pytest

from seoro.bridges import launch
from seoro.errors import UsageError


@pytest.mark.parametrize(
    ("simulator", "python", "words"),
    [
        ("mujoco", (3, 13), "pip install 'seoro[mujoco]'"),
        ("pybullet", (3, 11), "pip install 'seoro[pybullet]'"),
        ("pybullet", (3, 12), "with a Python older than 3.12"),
    ],
)
def test_a_missing_simulator_is_reported_with_its_installation(
    monkeypatch: pytest.MonkeyPatch, simulator: str, python: tuple[int, int], words: str
) -> None:
    def nothing(_module: str) -> ModuleSpec | None:
        return None

    monkeypatch.setattr(launch, "find_spec", nothing)
    monkeypatch.setattr(sys, "version_info", python)
    with pytest.raises(UsageError, match=f"the simulator '{simulator}' is not installed") as refused:
        launch.check_installed(simulator)
    assert words in str(refused.value.help)


def test_an_unknown_simulator_is_refused_with_the_known_ones() -> None:
    with pytest.raises(UsageError) as refused:
        launch.check_installed("gazebo")
    assert refused.value.help == "simulators: mujoco, pybullet"

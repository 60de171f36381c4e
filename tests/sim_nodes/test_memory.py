"""Memory of nodes: cleared memory that is not used is returned, and caches are bounded."""

from __future__ import annotations

import mmap
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from sim_nodes.memory import MAPS
from sim_nodes.navigation.cover import polygon_cover
from sim_nodes.robots.kinematics import _base_matrix, _wheel_matrix
from sim_nodes.robots.traction import traction_of
from sim_nodes.robots.urdf_check import link_parts

on_linux = pytest.mark.skipif(not MAPS.exists(), reason="needs /proc of Linux")

LEAST = 12  # [MiB] returned of a connection to Bullet

BULLET = """
from sim_nodes.memory import zeros_returned
from sim_nodes.pybullet.engine import PybulletEngine
from tests.sim_nodes.test_memory import resident

before = resident()
kept = PybulletEngine()
between = resident()
with zeros_returned():
    returned = PybulletEngine()
print(between - before, resident() - between)
"""

CONTENT = """
import mmap
import numpy as np
from sim_nodes.memory import zeros_returned
from tests.sim_nodes.test_memory import resident

with zeros_returned():
    array = np.frombuffer(mmap.mmap(-1, 16 << 20, flags=mmap.MAP_PRIVATE | mmap.MAP_ANONYMOUS), np.uint8)
    array[:] = 0
    array[8 << 20 : (8 << 20) + 5000] = 7
    before = resident()
print(before - resident(), array.sum())
"""


def resident() -> float:
    """Return the resident memory of this process [MiB]."""
    return int(Path("/proc/self/statm").read_text().split()[1]) * mmap.PAGESIZE / 2**20


def numbers_of(script: str) -> list[float]:
    """Return the numbers that a script prints last, in a process without other threads."""
    run = subprocess.run([sys.executable, "-c", script], check=True, capture_output=True, text=True)
    return [float(word) for word in run.stdout.split()[-2:]]


@on_linux
@pytest.mark.engine("pybullet")
def test_a_connection_to_bullet_takes_less_memory() -> None:
    whole, less = numbers_of(BULLET)
    assert less < whole - LEAST


GOAL = """
import numpy as np
from sim_nodes.navigation.grid_search import GoalField
from tests.sim_nodes.test_memory import resident

cost = np.ones((300, 300))
GoalField(cost[:4, :4], (0, 0))  # loads modules
before = resident()
field = GoalField(cost, (200, 200))
print(resident() - before, field.costs.nbytes / 2**20)
"""


@on_linux
def test_a_field_of_costs_takes_only_its_own_memory() -> None:
    taken, costs = numbers_of(GOAL)
    assert taken < 2.5 * costs  # with the steps to all cells


@on_linux
def test_content_is_kept() -> None:
    returned, content = numbers_of(CONTENT)
    assert returned > 12.0
    assert content == 5000 * 7


@pytest.mark.parametrize("cached", [polygon_cover, link_parts, traction_of, _wheel_matrix, _base_matrix])
def test_what_is_kept_of_robots_is_bounded(cached: Any) -> None:
    assert cached.cache_info().maxsize <= 64

from __future__ import annotations

import hashlib
import subprocess
import sys

import pytest

from seoro.bridges import wire
from tests.sim_nodes.client import ROBOT, Client, pose
from tests.sim_nodes.engines import MUJOCO_FIRST, PYBULLET_IN_MORE

SCRIPT = """
from tests.sim_nodes.test_determinism import fingerprint
import sys
sys.stdout.write(fingerprint(5, {engine!r}))
"""


def fingerprint(seed: int, engine: str) -> str:
    """Return a hash of all answers, and of the full state at every half second, of a short run."""
    client = Client("maze", seed, engine)
    digest = hashlib.sha256()
    client.localise()
    client.navigate(pose(1.5, 0.0))
    client.watch(1.0, 1.5, 0.5)
    time = 0.0
    while time < 12.0:
        advanced = client.advance(time + 0.5)
        time = advanced.time
        if advanced.occurrences:
            client.spawn("box", pose(1.9, 0.6, z=0.05))
        state = client.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=ROBOT))
        digest.update(wire.encode(advanced) + wire.encode(state) + repr(client.estimate).encode())
    return digest.hexdigest()


@pytest.mark.parametrize("engine", MUJOCO_FIRST)
def test_a_run_in_another_process_is_bit_identical(engine: str) -> None:
    expected = fingerprint(5, engine)
    command = [sys.executable, "-c", SCRIPT.format(engine=engine)]
    other = subprocess.run(command, capture_output=True, text=True, check=True, timeout=60)
    assert other.stdout == expected


@pytest.mark.more
def test_another_seed_gives_another_run() -> None:
    assert fingerprint(5, "mujoco") != fingerprint(6, "mujoco")


@pytest.mark.parametrize("engine", PYBULLET_IN_MORE)
def test_a_reset_repeats_the_run(engine: str) -> None:
    client = Client("maze", 2, engine)
    states = []
    for _ in range(2):
        client.localise()
        client.navigate(pose(1.5, 1.5))
        client.advance(4.0)
        states.append((client.truth, client.estimate))
        client.ask(wire.RESET_SIMULATION, wire.ResetSimulation())
    assert states[0] == states[1]


@pytest.mark.parametrize("engine", PYBULLET_IN_MORE)
def test_the_size_of_grants_does_not_change_the_run(engine: str) -> None:
    ends = []
    for grant in (0.004, 0.03, 3.0):
        client = Client("maze", 2, engine)
        client.localise()
        client.navigate(pose(1.5, 1.5))
        time = 0.0
        while time < 3.0:
            time = client.advance(min(3.0, time + grant)).time
        ends.append((client.truth, client.estimate))
    assert ends[0] == ends[1] == ends[2]


@pytest.mark.parametrize("engine", PYBULLET_IN_MORE)
def test_watches_do_not_change_the_run(engine: str) -> None:
    watched, unwatched = Client("maze", 2, engine), Client("maze", 2, engine)
    watched.watch(4.5, 4.5, 0.1, frame="base_link")
    for client in (watched, unwatched):
        client.localise()
        client.navigate(pose(1.5, 1.5))
        client.advance(3.0)
    assert watched.truth == unwatched.truth

"""The ways to a lab: its nodes and robots, seen from here and by an executor, with the keys of several roles."""

from __future__ import annotations

import os
import signal
from collections.abc import Iterator
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

import anyio
import pytest

from seoro.bridges.wire.keys import NAMESPACE, node_token
from seoro.doctor.findings import Finding, Health
from seoro.doctor.lab import Places, look_at_lab
from seoro.doctor.path import look_along
from seoro.errors import InvalidUse
from seoro.keys.roles import Role
from seoro.lab.commanding import release_all, stop_all
from seoro.lab.reading import Lab, read_lab
from tests.labs import NAME, KeyedLab, RunningCommand, command, free_port, keyed_executor, make_lab
from tests.routers import free_endpoint, router_process
from tests.sim_nodes.engines import make_engine

DEADLINE = 60.0  # [s]
LAB = """
simulators:
  hall: {{connect: {endpoint}, name: hall}}
bridges:
  floor: {{connect: {endpoint}, name: floor}}
robots:
  leader: {{in: hall, as: turtlebot4, before: {{localised: true}}}}
  follower: {{in: hall, as: second}}
  third: {{in: hall}}
  carrier: {{in: floor}}
"""


@dataclass(frozen=True)
class Keyed:
    """A lab with keys: where its router is, its lab file, its keys, and the process of its simulator."""

    endpoint: str
    file: Lab
    lab: KeyedLab
    hall: RunningCommand

    @property
    def places(self) -> Places:
        return Places(self.file.endpoints, self.file)


@pytest.fixture(scope="module")
def running(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Keyed]:
    make_engine("mujoco")
    folder = tmp_path_factory.mktemp("x")
    lab = make_lab(folder / "keys")
    lab.authority.add("rob", Role.OPERATOR, lab.keys("rob"))
    lab.authority.add("hall", Role.NODE, lab.keys("hall"))
    endpoint = f"tls/127.0.0.1:{free_port()}"
    (folder / "lab.yaml").write_text(LAB.format(endpoint=endpoint))
    router = ("router", "--listen", endpoint, "--keys", str(lab.keys("hub")))
    hall = ("sim", "mujoco", "--world", "hall", "--rate", "1", "--connect", endpoint)
    with ExitStack() as stack:
        stack.enter_context(command(folder / "router.log", endpoint, *router))
        stack.enter_context(keyed_executor(folder, lab, connect=endpoint))
        keys = ("--keys", str(lab.keys("hall")))
        running = stack.enter_context(command(folder / "hall.log", endpoint, *hall, *keys))
        yield Keyed(endpoint, read_lab(folder / "lab.yaml"), lab, running)


@pytest.fixture
async def keyed(running: Keyed) -> Keyed:
    """The lab, once its nodes are there: they take a moment to be back when somebody was revoked."""
    await come_back(running)
    return running


async def come_back(running: Keyed) -> None:
    """Wait until the nodes are there."""
    with anyio.fail_after(DEADLINE):
        while not has(await look(running, "anna", Places((running.endpoint,))), "ok hall: lets us, anna"):
            pass


async def look(keyed: Keyed, who: str, places: Places | None = None) -> list[str]:
    """The lines that somebody gets to see."""
    found = look_along(keyed.endpoint, None, keyed.lab.keys(who), places or keyed.places)
    return [line(finding) async for finding in found]


def line(finding: Finding) -> str:
    assert finding.help or finding.health is Health.OK
    return f"{finding.health.value} {finding.what}: {finding.text}"


def has(lines: list[str], *parts: str) -> bool:
    return any(all(part in line for part in parts) for line in lines)


@pytest.mark.slow
async def test_an_operator_sees_nodes_and_robots_from_here_and_from_the_executor(keyed: Keyed) -> None:
    lines = await look(keyed, "anna")
    assert has(lines, f"ok {NAME}: lets us, anna (operator), submit runs")
    for prefix, who in (("", "us, anna (operator),"), (f"{NAME} sees ", f"it, {NAME} (executor),")):
        assert has(
            lines, f"ok {prefix}hall: is a simulator (mujoco) of seoro", "version 1 of the protocol, as this"
        )
        assert has(lines, f"ok {prefix}hall: lets {who} look and use its robots")
        assert has(lines, f"ok {prefix}hall: its clock is", "give or take")
        assert has(lines, f"{prefix}hall: answers in", "(p50)", "(p99 of")
        assert has(
            lines, f"ok {prefix}hall/turtlebot4 (leader): heard of now, free, does not know where it is yet"
        )
        assert has(lines, f"warning {prefix}hall/turtlebot4 (leader): is not ready", "does not know where it is")
        assert has(lines, f"ok {prefix}hall/second (follower): heard of now, free")
        assert has(lines, f"failed {prefix}hall/third: robot 'third' of the lab file is not there")
        assert has(lines, f"failed {prefix}floor: is not there at {keyed.endpoint}: there are hall")


async def test_a_viewer_sees_the_lab_and_what_a_viewer_may_not(keyed: Keyed) -> None:
    lines = await look(keyed, "vera")
    assert has(lines, f"ok {NAME}: lets us, vera (viewer), look; submitting runs is for operators")
    assert has(lines, "ok hall: lets us, vera (viewer), look; using robots is for operators")
    assert has(lines, "ok hall/second (follower): heard of now")
    assert has(lines, f"warning {NAME}: does not say what it sees of the lab", "`look` is for one who is operator")


@pytest.mark.slow
async def test_a_node_that_stands_still_is_told_and_the_rest_as_well(keyed: Keyed) -> None:
    lines: list[str] = []
    with anyio.fail_after(DEADLINE):
        # The router may be letting everybody in anew: who stands still then does not come, or not whole.
        while not has(lines, "failed hall: ", "did not answer"):
            await come_back(keyed)
            os.kill(keyed.hall.process.pid, signal.SIGSTOP)
            try:
                lines = await look(keyed, "anna", Places())
            finally:
                os.kill(keyed.hall.process.pid, signal.SIGCONT)
    assert has(lines, f"ok {NAME}: ")


async def test_an_emergency_stop_is_told_of_nodes_and_executors(
    keyed: Keyed, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SEORO_KEYS", str(keyed.lab.keys("anna")))
    await stop_all([keyed.endpoint], "ana@lab", "smoke")
    try:
        lines = await look(keyed, "vera", Places())
    finally:
        await release_all([keyed.endpoint], "ana@lab", "it was toast")
    assert has(lines, "failed hall: nothing moves there: emergency stop by ana@lab", "(smoke)")
    assert has(lines, f"failed {NAME}: begins no runs: emergency stop by ana@lab", "(smoke)")


async def test_what_only_executors_need_is_no_failure_here(keyed: Keyed, tmp_path: Path) -> None:
    places = Places((f"unixsock-stream/{tmp_path}/nobody",))
    [alone] = [each async for each in look_at_lab(places, None)]
    [beside] = [each async for each in look_at_lab(places, None, is_needed=False)]
    assert (alone.health, beside.health) == (Health.FAILED, Health.WARNING)
    assert "runs on executors need what these see only" in beside.help
    lines = await look(keyed, "anna", places)
    assert has(lines, f"failed {NAME} sees {places.endpoints[0]}: there is no session")


async def test_executors_look_only_where_runs_may_reach(keyed: Keyed) -> None:
    lines = await look(keyed, "anna", Places(("tls/192.0.2.1:7447",)))
    assert has(
        lines, f"failed {NAME} sees tls/192.0.2.1:7447: it is not looked at", "does not let scenarios reach"
    )


async def test_whoever_is_revoked_is_told_that_this_may_be_why_nobody_is_seen(keyed: Keyed) -> None:
    """Comes last of those that share the lab: the router lets everybody in anew, which takes them a moment."""
    keyed.lab.revoke("rob", "hub", NAME)
    hall: Finding | None = None
    with anyio.fail_after(DEADLINE):
        while hall is None or hall.health is not Health.FAILED:  # until the router has noticed
            looking = look_along(keyed.endpoint, None, keyed.lab.keys("rob"), keyed.places)
            hall = {each.what: each async for each in looking}.get("hall")
    assert "is not there" in hall.text
    assert "whose keys are revoked sees nobody" in hall.help
    assert "rob (operator)" in hall.help


async def test_nodes_that_cannot_be_spoken_with_are_told() -> None:
    from seoro.bridges.session import open_session

    endpoint = free_endpoint()
    with router_process(endpoint):
        async with open_session(connect=endpoint) as session:
            older = node_token(NAMESPACE, "older", "b00t").replace("/1/", "/0/", 1)
            twins = [node_token(NAMESPACE, "twin", boot) for boot in ("a", "b")]
            async with session.token(older), session.token(twins[0]), session.token(twins[1]):
                lines = [line(each) async for each in look_at_lab(Places((endpoint,)), None)]
    assert has(lines, "failed older: speaks version 0 of the protocol")
    assert has(lines, "failed twin: 2 nodes", "have this name")
    assert has(lines, "failed twin: ", "is gone")


async def test_a_simulator_that_runs_start_is_looked_for_here(tmp_path: Path) -> None:
    file = tmp_path / "lab.yaml"
    file.write_text("simulators:\n  hall: {simulator: mujoco}\n")
    [found] = [each async for each in look_at_lab(Places((), read_lab(file)), None)]
    assert "is started for each run" in found.text
    file.write_text("simulators:\n  hall: {simulator: gazebo}\n")
    [found] = [each async for each in look_at_lab(Places((), read_lab(file)), None)]
    assert found.health is Health.FAILED
    assert "mujoco" in found.help
    with pytest.raises(InvalidUse):
        read_lab(tmp_path / "nothing.yaml")

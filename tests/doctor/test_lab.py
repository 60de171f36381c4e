"""Paths to the nodes and robots of a lab, from here and from an executor, with keys of several roles."""

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
from seoro.doctor.lab import Places, check_lab
from seoro.doctor.path import check_path_to_executors
from seoro.errors import UsageError
from seoro.lab.commands import LabCommands
from seoro.lab.reading import Lab, read_lab
from seoro.security.keys.roles import Role
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
    """Lab with keys: endpoint of its router, lab file, keys, and process of its simulator."""

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
    """Return the lab once its nodes are up, which takes a moment after a revocation."""
    await come_back(running)
    return running


async def come_back(running: Keyed) -> None:
    """Wait until the nodes are up."""
    with anyio.fail_after(DEADLINE):
        while not has(await look(running, "anna", Places((running.endpoint,))), "ok hall: we (anna"):
            pass


async def look(keyed: Keyed, who: str, places: Places | None = None) -> list[str]:
    """Return the lines of the findings for an identity."""
    found = check_path_to_executors(keyed.endpoint, None, keyed.lab.keys(who), places or keyed.places)
    return [line(finding) async for finding in found]


def line(finding: Finding) -> str:
    assert finding.help or finding.health is Health.OK
    return f"{finding.health.value} {finding.what}: {finding.text}"


def has(lines: list[str], *parts: str) -> bool:
    return any(all(part in line for part in parts) for line in lines)


@pytest.mark.more
async def test_an_operator_sees_the_lab_from_here_and_from_the_executor(keyed: Keyed) -> None:
    lines = await look(keyed, "anna")
    assert has(lines, f"ok {NAME}: we (anna (operator)) can submit runs")
    for prefix, who in (("", "we (anna (operator))"), (f"{NAME} sees ", f"it ({NAME} (executor))")):
        assert has(lines, f"ok {prefix}hall: simulator (mujoco), ", "protocol 1, same as here")
        assert has(lines, f"ok {prefix}hall: {who} can query it and use its robots")
        assert has(lines, f"ok {prefix}hall: its clock is", "give or take")
        assert has(lines, f"{prefix}hall: latency", "(p50)", "(p99 of")
        assert has(lines, f"ok {prefix}hall/turtlebot4 (leader): seen now, free, not localised yet")
        assert has(lines, f"warning {prefix}hall/turtlebot4 (leader): not ready", "it is not localised")
        assert has(lines, f"ok {prefix}hall/second (follower): seen now, free")
        assert has(lines, f"failed {prefix}hall/third: robot 'third' of the lab file not found")
        assert has(lines, f"failed {prefix}floor: not found at {keyed.endpoint}: nodes there: hall")


async def test_a_viewer_sees_the_lab_and_missing_permissions(keyed: Keyed) -> None:
    lines = await look(keyed, "vera")
    assert has(lines, f"ok {NAME}: we (vera (viewer)) can query it; only operators can submit runs")
    assert has(lines, "ok hall: we (vera (viewer)) can query it; only operators can use robots")
    assert has(lines, "ok hall/second (follower): seen now")
    assert has(
        lines,
        f"warning {NAME}: refused to check its path to the lab",
        "may not send `look` (required role: operator)",
    )


@pytest.mark.more
async def test_a_hanging_node_is_reported_with_all_other_findings(keyed: Keyed) -> None:
    lines: list[str] = []
    with anyio.fail_after(DEADLINE):
        # The router may be readmitting nodes: a hanging one then does not appear, or only in part.
        while not has(lines, "failed hall: ", "did not answer"):
            await come_back(keyed)
            os.kill(keyed.hall.process.pid, signal.SIGSTOP)
            try:
                lines = await look(keyed, "anna", Places())
            finally:
                os.kill(keyed.hall.process.pid, signal.SIGCONT)
    assert has(lines, f"ok {NAME}: ")


async def test_an_emergency_stop_of_nodes_and_executors_is_reported(
    keyed: Keyed, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("SEORO_KEYS", str(keyed.lab.keys("anna")))
    await LabCommands([keyed.endpoint]).emergency_stop_all("ana@lab", "smoke")
    try:
        lines = await look(keyed, "vera", Places())
    finally:
        await LabCommands([keyed.endpoint]).release_all("ana@lab", "it was toast")
    assert has(lines, "failed hall: emergency stop by ana@lab", "(smoke)")
    assert has(lines, f"failed {NAME}: starts no runs: emergency stop by ana@lab", "(smoke)")


async def test_a_path_that_only_executors_need_is_a_warning(keyed: Keyed, tmp_path: Path) -> None:
    places = Places((f"unixsock-stream/{tmp_path}/nobody",))
    [alone] = [each async for each in check_lab(places, None)]
    [beside] = [each async for each in check_lab(places, None, is_needed=False)]
    assert (alone.health, beside.health) == (Health.FAILED, Health.WARNING)
    assert "runs on executors do not need this path" in beside.help
    lines = await look(keyed, "anna", places)
    assert has(lines, f"failed {NAME} sees {places.endpoints[0]}: no session")


async def test_executors_check_allowed_endpoints_only(keyed: Keyed) -> None:
    lines = await look(keyed, "anna", Places(("tls/192.0.2.1:7447",)))
    assert has(
        lines,
        f"failed {NAME} sees tls/192.0.2.1:7447: not checked",
        "does not allow scenarios to connect to",
    )


async def test_revoked_keys_are_suggested_as_the_reason_of_missing_nodes(keyed: Keyed) -> None:
    """Run last of the tests that share the lab: the router readmits all nodes, which takes a moment."""
    keyed.lab.revoke("rob", "hub", NAME)
    hall: Finding | None = None
    with anyio.fail_after(DEADLINE):
        while hall is None or hall.health is not Health.FAILED:  # until the router has noticed
            looking = check_path_to_executors(keyed.endpoint, None, keyed.lab.keys("rob"), keyed.places)
            hall = {each.what: each async for each in looking}.get("hall")
    assert "not found at" in hall.text
    assert "revoked keys see no nodes" in hall.help
    assert "rob (operator)" in hall.help


async def test_incompatible_and_duplicate_nodes_are_reported() -> None:
    from seoro.bridges.session import open_session

    endpoint = free_endpoint()
    with router_process(endpoint):
        async with open_session(connect=endpoint) as session:
            older = node_token(NAMESPACE, "older", "b00t").replace("/1/", "/0/", 1)
            twins = [node_token(NAMESPACE, "twin", boot) for boot in ("a", "b")]
            async with session.token(older), session.token(twins[0]), session.token(twins[1]):
                lines = [line(each) async for each in check_lab(Places((endpoint,)), None)]
    assert has(lines, "failed older: has protocol 0")
    assert has(lines, "failed twin: duplicate name of 2 nodes")
    assert has(lines, "failed twin: ", "is disconnected")


async def test_a_simulator_to_start_is_checked_locally(tmp_path: Path) -> None:
    file = tmp_path / "lab.yaml"
    file.write_text("simulators:\n  hall: {simulator: mujoco}\n")
    [found] = [each async for each in check_lab(Places((), read_lab(file)), None)]
    assert "started for each run" in found.text
    file.write_text("simulators:\n  hall: {simulator: gazebo}\n")
    [found] = [each async for each in check_lab(Places((), read_lab(file)), None)]
    assert found.health is Health.FAILED
    assert "mujoco" in found.help
    with pytest.raises(UsageError):
        read_lab(tmp_path / "nothing.yaml")

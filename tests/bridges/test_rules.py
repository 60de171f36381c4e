"""Nodes that violate the protocol: the run ends as an error with the node and the rule."""

from __future__ import annotations

import asyncio
from collections.abc import Callable, Iterator
from contextlib import ExitStack, contextmanager
from pathlib import Path

import pytest

import seoro
from seoro.bridges import wire
from seoro.bridges.conformance import check_backend
from seoro.bridges.launch import SimulatorOptions, connect_simulator
from seoro.bridges.models import ModelPath
from seoro.bridges.sim.rules import STALLED, ProtocolViolation, TimeRules
from seoro.errors import BackendError
from seoro.runtime.verdict import RunStatus, Verdict
from tests.routers import process

ODD_NODE = Path(__file__).with_name("odd_node.py")
TEXT = """import osc.helpers

scenario main:
    timeout(60s)
    do wait elapsed(3s)
"""

LOCALISED = """import osc.localization

scenario main:
    robot: differential_drive_robot
    do robot.check_localization(max_error: 0.5m)
"""

Run = Callable[..., Verdict]


@contextmanager
def odd_node(folder: Path, fault: str) -> Iterator[str]:
    endpoint = f"unixsock-stream/{folder}/odd"
    with process(str(ODD_NODE), endpoint, fault):
        yield endpoint


@pytest.fixture
def run(tmp_path: Path) -> Iterator[Run]:
    """Run a scenario with a faulty node."""
    with ExitStack() as stack:

        def run_with(fault: str, text: str = TEXT) -> Verdict:
            (tmp_path / "main.osc").write_text(text)
            endpoint = stack.enter_context(odd_node(tmp_path, fault))
            return seoro.run(seoro.load(tmp_path / "main.osc"), simulator=seoro.Simulator(endpoint=endpoint))

        yield run_with


def test_a_run_passes_with_a_correct_node(run: Run) -> None:
    verdict = run("nothing")
    assert verdict.status is RunStatus.PASSED, verdict.reason
    assert verdict.duration == 3.0


def test_a_run_fails_when_a_robot_leaves_its_world(run: Run) -> None:
    verdict = run("leaves")
    assert verdict.status is RunStatus.FAILED
    found, _, expected = verdict.reason.partition("; expected ")
    assert found == "robot left the world at (2.500, 0.000, 0.000) m, 1.000 s after the start"
    assert expected.startswith("x from -2 to 2 m and y from -2 to 2 m")
    assert verdict.duration == 1.0


@pytest.mark.parametrize(
    ("fault", "found", "expected"),
    [
        ("nan", "a time of nan s in the answer to a grant from 0 s to 1 s", "a finite time"),
        ("infinite", "a time of inf s", "a finite time"),
        ("back", "a time of 0.5 s in the answer to a grant from 1 s to 2 s|a time of 1.5 s", "never goes back"),
        ("beyond", "a time of 6 s in the answer to a grant from 0 s to 1 s", "a time within the grant"),
        ("stands", "less than half a step in 1000 grants, the last 0 s", "a clock that advances"),
        (
            "ahead",
            "a contact of 'robot' of 1.5 s in an answer from 0 s to 1 s",
            "occurrences within the simulated time",
        ),
        ("late", "a contact of 'robot' of -0.5 s", "occurrences within the simulated time"),
        ("time of nothing", "a contact of 'robot' of nan s", "occurrences within the simulated time"),
        ("goal", "the end of a goal or a watch 'goal-7'", "expected ids of this run"),
    ],
)
def test_a_node_that_breaks_a_rule_ends_the_run_as_an_error(
    run: Run, fault: str, found: str, expected: str
) -> None:
    verdict = run(fault)
    assert verdict.status is RunStatus.ERROR, verdict.reason
    assert verdict.reason.startswith("simulator 'odd' violated the protocol: it sent ")
    assert any(each in verdict.reason for each in found.split("|")), verdict.reason
    assert expected in verdict.reason


def test_a_clock_that_hardly_advances_is_an_error() -> None:
    features = wire.SimulatorFeatures(
        engine="odd",
        engine_version="1",
        version="1",
        features=(),
        spawn_formats=(),
        world="plain",
        available_worlds=("plain",),
        robots=(),
        time=0.0,
        step=0.01,
        state=wire.SimulationState.PAUSED,
    )
    rules = TimeRules("simulator 'odd'", features, lambda number: False)
    for number in range(STALLED - 1):
        rules.check(number * 1e-6, 1.0, wire.Advanced(time=(number + 1) * 1e-6))
    with pytest.raises(ProtocolViolation, match=r"less than half a step in 1000 grants, the last 0.001 s"):
        rules.check(999e-6, 1.0, wire.Advanced(time=1e-3))


@pytest.mark.parametrize(("fault", "shown"), [("error nan", "nan"), ("error -1", "-1")])
def test_an_invalid_localisation_error_ends_the_run_as_an_error(run: Run, fault: str, shown: str) -> None:
    verdict = run(fault, LOCALISED)
    assert verdict.status is RunStatus.ERROR, verdict.reason
    assert f"it sent the error of the localisation of 'robot' as {shown} m; expected a finite" in verdict.reason


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("step 0", "it sent a step of 0.0 s; expected a step above 0 s, and at most 1 s"),
        ("step nan", "it sent a step of nan s"),
        ("step -1", "it sent a step of -1.0 s"),
        ("first time", "it sent a time of nan s when its world was loaded; expected a finite time from 0 s on"),
    ],
)
def test_invalid_features_of_a_node_are_an_error_before_the_run(run: Run, fault: str, message: str) -> None:
    with pytest.raises(BackendError, match="simulator 'odd' violated the protocol: ") as caught:
        run(fault)
    assert message in str(caught.value)


def test_a_node_of_another_version_is_refused_with_both_versions(
    run: Run, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("seoro.bridges.finding.TIMEOUT", 0.5)
    with pytest.raises(
        BackendError, match=r"the node 'odd' at .* speaks version 2 of the protocol; expected version 1"
    ):
        run("version")


def test_conformance_checks_announced_features_only(tmp_path: Path) -> None:
    options = SimulatorOptions(None, 1, ModelPath())
    with odd_node(tmp_path, "nothing") as endpoint:
        lacks = asyncio.run(check_backend(lambda: connect_simulator(endpoint, options)))
    assert {"DrivenRobots", "Simulation", "Faults"} < set(lacks)


@pytest.mark.parametrize(
    ("fault", "message"),
    [
        ("beyond", "at most a step beyond. But simulator 'odd' violated the protocol: it sent a time of 5.02 s"),
        (
            "step 0",
            "at time zero, with its robots at rest. But simulator 'odd' violated the protocol: it sent a",
        ),
    ],
)
def test_conformance_reports_the_rule_that_a_node_breaks(tmp_path: Path, fault: str, message: str) -> None:
    options = SimulatorOptions(None, 1, ModelPath())
    with odd_node(tmp_path, fault) as endpoint, pytest.raises(AssertionError) as caught:
        asyncio.run(check_backend(lambda: connect_simulator(endpoint, options)))
    assert message in str(caught.value)

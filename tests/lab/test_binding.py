"""Assignment of robots to actors by name, type or capability: the first free and ready robot."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import seoro
from seoro.bridges import wire
from seoro.bridges.robot.connecting import RobotsBusy
from seoro.errors import BackendUnreachable, UsageError
from seoro.lab.binding import bind
from seoro.lab.reading import Lab, read_lab
from seoro.lab.selectors import Selector, split_selectors
from seoro.runtime.verdict import RunStatus
from tests.bridges.robot.conftest import Rails
from tests.lab.test_runs import ALONE, lab_of
from tests.lab.test_runs import run as run_scenario
from tests.sim_nodes.engines import make_engine

LAB = """bridges:
  floor: {connect: tcp/127.0.0.1:7460}
robots:
  tb1: {in: floor, type: turtlebot4, before: {battery: 0.3}}
  tb2: {in: floor, type: turtlebot4, can: [carry]}
  arm: {in: floor, type: ur5e}
"""
ANY = Selector("turtlebot4", is_name=False)


@pytest.fixture
def lab(tmp_path: Path) -> Lab:
    (tmp_path / "lab.yaml").write_text(LAB)
    return read_lab(tmp_path / "lab.yaml")


def state(name: str, **how: Any) -> wire.RobotState:
    return wire.RobotState(name=name, kinds=("differential_drive_robot",), **{"battery": 0.9, **how})


def states(**robots: wire.RobotState | str) -> dict[str, wire.RobotState | str]:
    return {**{name: state(name) for name in ("tb1", "tb2", "arm")}, **robots}


def test_selectors_are_separated_from_values() -> None:
    plain, selectors = split_selectors({"speed": "3mps", "robot": "any:turtlebot4", "other": "robot:tb1"})
    assert plain == {"speed": "3mps"}
    assert selectors == {"robot": ANY, "other": Selector("tb1", is_name=True)}


def test_the_first_free_and_ready_robot_is_chosen(lab: Lab) -> None:
    def chosen(**how: wire.RobotState | str) -> str:
        return bind(lab, {"robot"}, {"robot": ANY}, states(**how), "", may_wait=False)["robot"]

    assert chosen() == "tb1"
    assert chosen(tb1=state("tb1", holder="a run")) == "tb2"
    assert chosen(tb1=state("tb1", battery=0.12)) == "tb2"
    assert chosen(tb1="nothing answers") == "tb2"


def test_actors_have_distinct_robots_and_named_ones_are_assigned_first(lab: Lab) -> None:
    selectors = {"first": ANY, "second": Selector("tb1", is_name=True)}
    bound = bind(lab, {"first", "second"}, selectors, states(), "", may_wait=False)
    assert bound == {"second": "tb1", "first": "tb2"}


def test_capabilities_select_robots(lab: Lab) -> None:
    bound = bind(lab, {"robot"}, {"robot": Selector("carry", is_name=False)}, states(), "", may_wait=False)
    assert bound == {"robot": "tb2"}


def test_a_refusal_lists_the_reason_of_each_robot(lab: Lab) -> None:
    busy = states(tb1=state("tb1", battery=0.12), tb2=state("tb2", holder="the scenario go of ana@lab"))
    words = "tb1: its battery is at 12%, below 30% - tb2: held by the scenario go of ana@lab"
    with pytest.raises(RobotsBusy, match=words):
        bind(lab, {"robot"}, {"robot": ANY}, busy, "", may_wait=False)
    assert bind(lab, {"robot"}, {"robot": ANY}, busy, "", may_wait=True) == {"robot": "tb2"}


@pytest.mark.parametrize(
    ("actor", "selector", "words"),
    [
        ("robot", Selector("drone", is_name=False), "no 'drone' in the lab for the actor `robot`"),
        ("robot", Selector("tb9", is_name=True), "unknown robot 'tb9' for the actor `robot`"),
        ("driver", ANY, "the unknown actor 'driver'"),
    ],
)
def test_impossible_selectors_are_refused_with_the_reason(
    lab: Lab, actor: str, selector: Selector, words: str
) -> None:
    with pytest.raises(UsageError, match=words):
        bind(lab, {"robot"}, {actor: selector}, states(), "", may_wait=False)


def test_a_leased_robot_needs_its_lease(lab: Lab) -> None:
    lease = wire.Lease(lease="hand-1", purpose="wheels", until=0.0)
    leased = states(tb1=state("tb1", lease=lease), tb2=state("tb2", lease=lease))
    assert bind(lab, {"robot"}, {"robot": ANY}, leased, "hand-1", may_wait=False) == {"robot": "tb1"}
    with pytest.raises(RobotsBusy, match=r"tb1: leased \(wheels\)"):
        bind(lab, {"robot"}, {"robot": ANY}, leased, "", may_wait=False)


# ---------------------------------------------------------------- in runs


def floor(rails: Rails, robots: str) -> str:
    return f"bridges:\n  floor: {{connect: {rails.endpoint}}}\nrobots:\n{robots}"


@pytest.fixture
def two(start_rails: Callable[..., Rails], tmp_path: Path) -> Rails:
    return start_rails("--listen", f"unixsock-stream/{tmp_path}/rails", "line", "second")


def test_the_trace_has_the_robot_of_each_actor(two: Rails, tmp_path: Path) -> None:
    robots = "  one: {in: floor, as: second, type: cart}\n  other: {in: floor, as: line, type: cart}\n"
    lab = lab_of(tmp_path, floor(two, robots))
    records: list[dict[str, Any]] = []

    class Keep:
        def record(self, record: dict[str, Any]) -> None:
            records.append(record)

    verdict = run_scenario(tmp_path, ALONE, lab, overrides={"leader": "any:cart"}, observers=(Keep(),))
    assert verdict.status is RunStatus.PASSED, verdict.reason
    assert records[0]["robots"] == {"leader": "second of bridge 'rails'"}
    assert {name for _, name, velocity in two.commands() if velocity} == {"second"}


def test_an_actor_without_a_robot_is_refused_with_the_robots_of_the_lab(two: Rails, tmp_path: Path) -> None:
    robots = "  one: {in: floor, as: second, type: cart}\n  other: {in: floor, as: line, type: cart}\n"
    lab = lab_of(tmp_path, floor(two, robots))
    with pytest.raises(UsageError) as caught:
        run_scenario(tmp_path, ALONE, lab)
    assert caught.value.help == "robots of the lab: one, other; choose one with `--set leader=robot:one`"


def test_selectors_without_a_lab_are_refused(tmp_path: Path) -> None:
    (tmp_path / "go.osc").write_text(ALONE)
    with pytest.raises(UsageError, match="the actor `leader` needs a robot of a lab"):
        seoro.run(seoro.load(tmp_path / "go.osc"), overrides={"leader": "any:cart"})


def test_a_robot_that_is_not_ready_is_refused(two: Rails, tmp_path: Path) -> None:
    robots = "  leader: {in: floor, as: line, before: {battery: 0.8, area: {x: [5, 6], y: [0, 1]}}}\n"
    words = r"lab\.yaml:4: robots\.leader is not ready: its battery is at 50%, below 80%; it is at x 0\.00 m"
    with pytest.raises(UsageError, match=words):
        run_scenario(tmp_path, ALONE, lab_of(tmp_path, floor(two, robots)))


@pytest.mark.more
def test_the_charge_of_a_simulated_robot_is_checked(tmp_path: Path) -> None:
    make_engine("mujoco")
    robot = "{name: cart, robot: turtlebot4, battery: {capacity: 26, idle: 9, driving: 20, charge: 0.5}}"
    (tmp_path / "w.yaml").write_text(f"name: w\nextent: [-4, -4, 4, 4]\nrobots: [{robot}]\n")
    text = "simulators:\n  sim: {simulator: mujoco, world: w.yaml}\nrobots:\n"
    text += "  leader: {in: sim, as: cart, before: {battery: CHARGE}}\n"
    short = ALONE.partition("    do")[0] + "    do serial:\n        wait elapsed(0.1s)\n"
    assert run_scenario(tmp_path, short, lab_of(tmp_path, text.replace("CHARGE", "0.4"))).passed
    with pytest.raises(UsageError, match=r"lab\.yaml:4: .* its battery is at 50%, below 60%"):
        run_scenario(tmp_path, short, lab_of(tmp_path, text.replace("CHARGE", "0.6")))


def test_a_goal_beyond_the_limits_of_the_lab_fails_the_run(two: Rails, tmp_path: Path) -> None:
    robots = "  leader: {in: floor, as: line, limits: {area: {x: [0, 0.1], y: [-1, 1]}}}\n"
    verdict = run_scenario(tmp_path, ALONE, lab_of(tmp_path, floor(two, robots)))
    assert verdict.status is RunStatus.FAILED
    assert "outside the area of the robot 'line' in this lab" in verdict.reason


def test_a_robot_drives_home_after_the_run(two: Rails, tmp_path: Path) -> None:
    robots = "  leader: {in: floor, as: line, after: {home: {x: 0.5, y: 0}}}\n"
    before = len(two.commands())
    assert run_scenario(tmp_path, ALONE, lab_of(tmp_path, floor(two, robots))).status is RunStatus.PASSED
    velocities = [velocity for _, name, velocity in two.commands()[before:] if name == "line"]
    assert [velocity for velocity in velocities if velocity] == [0.5, 0.5]  # to its goal, then home
    assert velocities[-1] == 0.0


def test_robots_of_unreachable_nodes_may_be_waited_for(lab: Lab) -> None:
    silent = states(tb1=state("tb1", battery=0.12), tb2="nothing answers")
    with pytest.raises(BackendUnreachable, match=r"tb1: its battery is at .* - tb2: nothing answers"):
        bind(lab, {"robot"}, {"robot": ANY}, silent, "", may_wait=True)
    unknown = Selector("forklift", is_name=False)
    with pytest.raises(BackendUnreachable, match="unknown types of robots: tb2: nothing answers"):
        bind(lab, {"robot"}, {"robot": unknown}, silent, "", may_wait=True)

from __future__ import annotations

import math
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome, Result
from seoro.bridges.wire.refusal import RequestRefused
from tests.sim_nodes.client import ROBOT, Client, pose


def test_a_goal_is_reached_with_its_heading_and_the_robot_stands(empty: Client) -> None:
    empty.localise()
    empty.navigate(pose(1.0, 1.0, math.pi / 2))
    ended, _ = empty.run_until("goal")
    assert ended.outcome is Outcome.SUCCEEDED
    assert empty.truth.distance(1.0, 1.0) < 0.15
    assert empty.truth.yaw == pytest.approx(math.pi / 2, abs=0.2)
    speed = empty.ask(wire.GET_ENTITY_STATE, wire.EntityName(name=ROBOT)).twist.linear
    assert math.hypot(speed.x, speed.y) < 0.02


def passed(client: Client, x: float, y: float) -> float:
    """Return the smallest distance of the robot's path to a point [m]."""
    path = client.simulator.simulation.run_data.records[ROBOT].path
    return min(math.dist(point, (x, y)) for point in path)


def test_intermediate_poses_are_passed_without_a_stop(empty: Client) -> None:
    empty.localise()
    empty.navigate(pose(1.0, 0.0, math.pi), pose(1.5, 1.0))
    ended, _ = empty.run_until("goal")
    assert ended.outcome is Outcome.SUCCEEDED
    assert passed(empty, 1.0, 0.0) < 0.35
    assert empty.truth.distance(1.5, 1.0) < 0.15


def test_with_stop_at_each_the_robot_takes_the_heading_of_each(empty: Client) -> None:
    times = []
    for stop in (False, True):
        empty.ask(wire.RESET_SIMULATION, wire.ResetSimulation())
        empty.localise()
        empty.navigate(pose(1.0, 0.0, math.pi / 2), pose(2.0, 0.0), stop_at_each=stop)
        times.append(empty.run_until("goal")[0].time)
        assert passed(empty, 1.0, 0.0) < 0.35
    assert times[1] > times[0] + 2.0, "it turned at the first pose, and back"


@pytest.mark.parametrize(
    ("goal", "words"),
    [
        (
            (2.25, 2.0),
            r"goal \(2.25, 2.00\) is inside an obstacle of the map; expected a clearance of 0.18 m or more",
        ),
        ((2.15, 2.0), r"goal \(2.15, 2.00\) is 0.0\d m from an obstacle of the map"),
        ((7.0, 0.0), r"goal \(7.00, 0.00\) is outside of the map: x -5.35 to 5.\d\d"),
        ((5.33, 0.0), r"obstacle of the map"),
    ],
)
def test_a_goal_too_close_to_an_obstacle_is_refused(maze: Client, goal: tuple[float, float], words: str) -> None:
    maze.localise()
    with pytest.raises(RequestRefused, match=words) as refused:
        maze.navigate(pose(*goal))
    assert refused.value.code == Result.OPERATION_FAILED


def test_an_unreachable_goal_is_refused(tmp_path: Path) -> None:
    world = tmp_path / "cell.yaml"
    world.write_text(
        "name: cell\nextent: [-3, -3, 3, 3]\nwalls: [{points: [[1, -3], [1, 3]]}]\n"
        "robots: [{name: turtlebot4, robot: turtlebot4}]\n"
    )
    client = Client(str(world))
    client.localise()
    with pytest.raises(RequestRefused, match=r"goal \(2.00, 0.00\) is unreachable on the map"):
        client.navigate(pose(2.0, 0.0))
    client.navigate(pose(-2.0, 0.0))


def test_a_goal_without_localisation_is_refused(maze: Client) -> None:
    with pytest.raises(RequestRefused, match="set its initial pose first") as refused:
        maze.navigate(pose(1.5, 1.5))
    assert refused.value.code == Result.INCORRECT_STATE


def test_a_second_goal_is_refused_while_one_is_active(maze: Client) -> None:
    maze.localise()
    maze.navigate(pose(1.5, 1.5), goal="first")
    with pytest.raises(RequestRefused, match="busy with goal 'first'") as refused:
        maze.navigate(pose(1.5, 0.0), goal="second")
    assert refused.value.code == Result.INCORRECT_STATE


def test_a_canceled_goal_ends_and_the_robot_stops(empty: Client) -> None:
    empty.localise()
    empty.navigate(pose(3.0, 0.0))
    empty.advance(4.0)
    empty.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="goal"))
    [ended] = empty.advance(10.0).occurrences
    assert (ended.id, ended.time, ended.outcome) == ("goal", 4.0, Outcome.CANCELED)
    there = empty.truth
    empty.advance(6.0)
    assert empty.truth.distance(there.x, there.y) < 0.1
    with pytest.raises(RequestRefused, match="no active goal 'goal'") as refused:
        empty.ask(wire.CANCEL_GOAL, wire.CancelGoal(id="goal"))
    assert refused.value.code == Result.NOT_FOUND


def test_stopping_a_robot_cancels_its_goal(empty: Client) -> None:
    empty.ask(wire.STOP_ROBOT, wire.StopRobot(robot=ROBOT))
    empty.localise()
    empty.navigate(pose(3.0, 0.0))
    empty.ask(wire.STOP_ROBOT, wire.StopRobot(robot=ROBOT))
    [ended] = empty.advance(1.0).occurrences
    assert ended.outcome is Outcome.CANCELED


@pytest.mark.more
def test_a_blocked_robot_aborts_with_a_reason(maze: Client) -> None:
    maze.localise()
    maze.navigate(pose(1.5, -1.5))
    for index, x in enumerate((1.0, 1.5, 2.0)):
        maze.spawn(f"box{index}", pose(x, -0.3))
    ended, contacts = maze.run_until("goal", 120.0)
    assert ended.outcome is Outcome.ABORTED
    assert "on its way to (1.50, -1.50), also after 6 recoveries" in ended.message
    assert contacts == []


def test_unknown_robots_and_invalid_requests_are_refused(maze: Client) -> None:
    with pytest.raises(RequestRefused, match="unknown robot 'spot'; robots: turtlebot4") as refused:
        maze.ask(wire.SET_INITIAL_POSE, wire.SetInitialPose(robot="spot", pose=pose(0, 0)))
    assert refused.value.code == Result.NOT_FOUND
    maze.localise()
    with pytest.raises(RequestRefused, match="found 0 poses"):
        maze.navigate()
    with pytest.raises(RequestRefused, match="expected numbers within"):
        maze.navigate(pose(math.nan, 0.0))
    with pytest.raises(RequestRefused, match="expected 1 to 200"):
        maze.navigate(pose(1.5, 1.5), goal="")

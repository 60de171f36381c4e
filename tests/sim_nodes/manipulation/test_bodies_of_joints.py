"""Arms without a gripper, and bodies that move by position-controlled joints."""

from __future__ import annotations

import math
import re
from importlib import resources
from pathlib import Path

import pytest

from seoro.bridges import wire
from seoro.bridges.wire import Outcome, RobotName
from seoro.bridges.wire.refusal import RequestRefused
from tests.sim_nodes.client import Client
from tests.sim_nodes.manipulation.cell import down
from tests.sim_nodes.test_snapshots import restore, save

ENGINES = ("mujoco", "pybullet")
BODY = (
    '<{tag} name="{name}"><inertial><origin xyz="{place}"/><mass value="{mass}"/>'
    '<inertia ixx="{spread}" iyy="{spread}" izz="{spread}" ixy="0" ixz="0" iyz="0"/></inertial>'
    '<collision><origin xyz="{place}"/><geometry>{shape}</geometry></collision></{tag}>'
)
LEGS = {"front_left": (0.2, 0.1), "front_right": (0.2, -0.1), "hind_left": (-0.2, 0.1), "hind_right": (-0.2, -0.1)}
JOINT = "{{name: {name}, home: 0.2, max_acceleration: 20.0, stiffness: 300.0, damping: 10.0, armature: 0.1}}"


def write_world(folder: Path, urdf: str, declaration: str, place: str = "") -> str:
    """Write a world with one robot, `mine`; return its path."""
    (folder / "mine.urdf").write_text(urdf)
    (folder / "mine.yaml").write_text(declaration)
    world = folder / "w.yaml"
    world.write_text(
        f"name: w\nextent: [-2, -2, 2, 2]\nrobots: [{{name: mine, robot: mine.yaml, pose: {{{place}}}}}]\n"
    )
    return str(world)


def four_legs() -> str:
    """Return the URDF of a body with a leg of one joint at each corner."""
    box = BODY.format(
        tag="link", name="trunk", place="0 0 0", mass=8.0, spread=0.1, shape='<box size="0.5 0.2 0.1"/>'
    )
    text = f'<robot name="four">{box}'
    for name, (x, y) in LEGS.items():
        shape = '<box size="0.03 0.03 0.3"/>'
        text += BODY.format(tag="link", name=name, place="0 0 -0.15", mass=0.5, spread=0.004, shape=shape)
        text += (
            f'<joint name="{name}_hip" type="revolute"><origin xyz="{x} {y} 0"/><parent link="trunk"/>'
            f'<child link="{name}"/><axis xyz="0 1 0"/>'
            '<limit lower="-1" upper="1" velocity="5" effort="40"/></joint>'
        )
    return text + "</robot>"


def walker(folder: Path) -> str:
    """Write a world with a body on four legs."""
    joints = ", ".join(JOINT.format(name=f"{leg}_hip") for leg in LEGS)
    declaration = (
        "model: four\nurdf: mine.urdf\nkinds: [jointed_robot, robot, osc_actor]\nbase_link: trunk\n"
        f"body_friction: 1.0\nstanding_height: 0.3\narm: {{joints: [{joints}]}}\n"
    )
    return write_world(folder, four_legs(), declaration)


def follow(client: Client, *points: list[float]) -> wire.Occurrence:
    """Move the joints of `mine` through points; return the result."""
    request = wire.FollowJointTrajectory(
        id="move", robot="mine", points=points, max_velocity_scaling_factor=0.5, tolerance=0.05
    )
    client.ask(wire.FOLLOW_JOINT_TRAJECTORY, request)
    return client.run_until("move")[0]


@pytest.mark.parametrize("engine", ENGINES)
def test_an_arm_without_a_gripper_moves(tmp_path: Path, engine: str) -> None:
    robots = resources.files("sim_nodes.robots")
    declaration = robots.joinpath("ur10e.yaml").read_text(encoding="utf-8").replace("ur10e.urdf", "mine.urdf")
    bare = re.sub(r"  gripper:\n(    .*\n)+", "", declaration)
    assert "stroke" not in bare
    urdf = robots.joinpath("ur10e.urdf").read_text(encoding="utf-8")
    client = Client(write_world(tmp_path, urdf, bare, "z: 0.5"), engine=engine)
    request = wire.MoveToPose(id="move", robot="mine", pose=down(0.6, 0.2, 0.3), frame="base_link")
    client.ask(wire.MOVE_TO_POSE, request)
    assert client.run_until("move")[0].outcome is Outcome.SUCCEEDED
    assert len(client.ask(wire.GET_JOINT_STATES, RobotName(robot="mine")).positions) == 6
    described = client.ask(wire.GET_ROBOT_DESCRIPTION, RobotName(robot="mine")).arm
    assert described is not None
    assert described.fingers == ()
    with pytest.raises(RequestRefused, match="mine has no gripper"):
        client.ask(wire.GRIPPER_COMMAND, wire.GripperCommand(id="grip", robot="mine", opening=0.0))


@pytest.mark.parametrize("engine", ENGINES)
def test_a_body_on_legs_stands_and_follows_a_trajectory(tmp_path: Path, engine: str) -> None:
    client = Client(walker(tmp_path), engine=engine)
    client.advance(1.0)
    height = client.simulator.simulation.engine.body_state("mine").position[2]
    assert 0.25 < height < 0.31
    client.advance(2.0)
    assert client.simulator.simulation.engine.body_state("mine").position[2] == pytest.approx(height, abs=2e-3)
    ended = follow(client, [-0.4, -0.4, -0.4, -0.4], [0.3, 0.3, 0.3, 0.3])
    assert ended.outcome is Outcome.SUCCEEDED, ended.message
    assert client.simulator.simulation.engine.body_state("mine").position[2] > 0.2
    with pytest.raises(RequestRefused, match="mine has no tool"):
        client.ask(wire.MOVE_TO_POSE, wire.MoveToPose(id="pose", robot="mine", pose=down(0.6, 0.2, 0.3)))
    with pytest.raises(RequestRefused, match=r"invalid position 1\.500 rad of front_left_hip"):
        follow(client, [1.5, 0.0, 0.0, 0.0])


def test_joints_without_a_name_keep_their_goal(tmp_path: Path) -> None:
    client = Client(walker(tmp_path))
    assert follow(client, [-0.3, 0.3, 0.3, 0.3]).outcome is Outcome.SUCCEEDED
    request = wire.FollowJointTrajectory(
        id="one", robot="mine", points=((0.0,),), joint_names=("hind_left_hip",), tolerance=0.05
    )
    client.ask(wire.FOLLOW_JOINT_TRAJECTORY, request)
    assert client.run_until("one")[0].outcome is Outcome.SUCCEEDED
    positions = client.ask(wire.GET_JOINT_STATES, RobotName(robot="mine")).positions
    assert positions == pytest.approx((-0.3, 0.3, 0.0, 0.3), abs=0.05)
    for names in (("hind_left_hip", "hind_left_hip"), ("hind_left_hip", "tail")):
        twice = request.model_copy(update={"joint_names": names, "points": ((0.0, 0.0),)})
        with pytest.raises(RequestRefused, match="expected different ones of mine: front_left_hip"):
            client.ask(wire.FOLLOW_JOINT_TRAJECTORY, twice)


def test_a_fixed_body_of_joints_is_at_its_standing_height(tmp_path: Path) -> None:
    world = walker(tmp_path)
    path = tmp_path / "mine.yaml"
    path.write_text(path.read_text().replace("standing_height", "fixed: true\nstanding_height"))
    client = Client(world)
    client.advance(0.5)
    assert client.simulator.simulation.engine.body_state("mine").position[2] == pytest.approx(0.3)


@pytest.mark.parametrize("engine", ENGINES)
def test_a_body_on_legs_continues_from_a_snapshot(tmp_path: Path, engine: str) -> None:
    ends = []
    original = Client(walker(tmp_path), engine=engine)
    request = wire.FollowJointTrajectory(
        id="move", robot="mine", points=([-0.4, 0.4, -0.4, 0.4],), max_velocity_scaling_factor=0.5
    )
    original.ask(wire.FOLLOW_JOINT_TRAJECTORY, request)
    original.advance(0.25)
    snapshot = save(original)
    for client in (original, Client("empty", 99, engine)):
        if client is not original:
            restore(client, snapshot)
        client.run_until("move")
        state = client.simulator.simulation.engine.body_state("mine")
        ends.append((state, client.ask(wire.GET_JOINT_STATES, RobotName(robot="mine"))))
    assert ends[0] == ends[1]
    assert math.isfinite(ends[0][0].position[0])

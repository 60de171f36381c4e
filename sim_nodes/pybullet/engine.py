"""The `Engine` of `sim_nodes.physics` by PyBullet.

Bullet keeps a body by its centre of mass, whose frame is turned to the principal axes of inertia; everything
here is by the origin of the body's own frame, and `_Body` has what lies between the two.

Bullet carries contacts over from step to step, which a call puts back only among the bodies that had them (see
`rewinding.py`). So a reset loads everything anew, in the same order: a world that is reset goes on as one that was
built. And a state that another process is to go on from is saved as what led to it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from importlib import metadata
from typing import Any

import numpy as np

from sim_nodes.colours import WALL, colour_of
from sim_nodes.geometry import Array, Quaternion, Vector, conjugate, multiply, rotated, rotation_matrix
from sim_nodes.journal import Journal, journaled, replay
from sim_nodes.physics import (
    FLOOR,
    OVERLAP,
    BodyModel,
    BodyState,
    Carried,
    JointStates,
    Overlap,
    PlacedRobot,
    Scene,
    TouchPoint,
)
from sim_nodes.pybullet.arm import BODY_B, DISTANCE, LINK_A, Ghost, Ghosts, PybulletArm, is_touching
from sim_nodes.pybullet.drive import PybulletDrive
from sim_nodes.pybullet.meeting import Meeting
from sim_nodes.pybullet.model import BASE, load_body, load_robot, walls_body, wxyz, xyzw
from sim_nodes.pybullet.output import caught
from sim_nodes.pybullet.rewinding import AT_ONCE, Checkpoint, LastStep, Saves, tie
from sim_nodes.views import Picture, View

with caught():  # it prints when it was built
    import pybullet
    from pybullet_utils.bullet_client import BulletClient

from sim_nodes.pybullet.camera import draw, floor_shapes
from sim_nodes.pybullet.stepping import RETRY, Stepper

GRAVITY = 9.81  # [m/s^2]
STEPS_PER_SECOND = 200
FIRST_ROBOT_GROUP = 8  # bit of the collision group of the first robot; those below are Bullet's own
ALL_GROUPS = -1
POSITION = 5  # of a contact point on the first body, among what Bullet says of it
NORMAL = 7  # of the contact, from the second body to the first
NO_SHAPE = -1  # to collide with


@dataclass(frozen=True)
class _Body:
    """A body: its number, and the frame of its mass in its own frame."""

    number: int
    static: bool
    centre: Vector
    axes: Quaternion


@dataclass(frozen=True)
class _Eye:
    """What a robot sees by, in Bullet."""

    body: int
    link: int  # of the lidar
    group: int  # collision group, which is the robot's alone


class PybulletEngine:
    """PyBullet with one scene; see `sim_nodes.physics.Engine` for what the methods do."""

    name = "pybullet"
    version = metadata.version("pybullet")
    steps_per_second = STEPS_PER_SECOND

    def __init__(self) -> None:
        with caught():
            self._bullet: Any = BulletClient(pybullet.DIRECT)
        self._client: int = self._bullet._client  # calls past the wrapper, which takes its time

    def build(self, scene: Scene) -> None:
        """See `Engine.build`."""
        self._scene = scene
        self._added: dict[str, tuple[BodyModel, BodyState]] = {}
        self._load()

    def reset(self) -> None:
        """See `Engine.reset`."""
        self._load()

    def save(self) -> Mapping[str, Any]:
        """See `SavesState.save`."""
        return {"added": self._at_start, **self.journal.save()}

    def restore(self, saved: Mapping[str, Any]) -> None:
        """See `SavesState.restore`."""
        self._added = dict(saved["added"])
        self._load()
        replay(saved, self, self._repeat)

    def _load(self) -> None:
        self.journal = Journal()
        self._at_start = dict(self._added)
        bullet = self._bullet
        bullet.resetSimulation()
        bullet.setGravity(0.0, 0.0, -GRAVITY)
        bullet.setPhysicsEngineParameter(
            fixedTimeStep=1.0 / STEPS_PER_SECOND,
            deterministicOverlappingPairs=1,
            minimumSolverIslandSize=AT_ONCE,
            enableFileCaching=0,
        )
        self._bodies: dict[str, _Body] = {}
        self._owners: dict[int, str] = {}
        self._static: set[int] = set()  # of the bodies, those that have a base which does not move
        self._meeting = Meeting(bullet)
        plane = bullet.createCollisionShape(pybullet.GEOM_PLANE)
        tiles, others = floor_shapes(bullet, self._scene.extent)
        floor = bullet.createMultiBody(0.0, plane, tiles)
        bullet.createMultiBody(0.0, NO_SHAPE, others)
        bullet.changeDynamics(floor, BASE, lateralFriction=1.0)
        self._owners[floor] = FLOOR
        self._static.add(floor)
        walls = self._scene.walls
        for name in dict.fromkeys(wall.name for wall in walls):
            model = walls_body(wall for wall in walls if wall.name == name)
            state = BodyState((0.0, 0.0, 0.0))
            number = load_body(bullet, model, state, WALL)
            self._note(name, number, static=True)
            self._meeting.stand(number, model.parts, state)
        self._drives: dict[str, PybulletDrive] = {}
        self._eyes: dict[str, _Eye] = {}
        self._arms: dict[str, PybulletArm] = {}
        self._ghosts = Ghosts(bullet)
        self._links: dict[str, dict[str, int]] = {}
        for index, robot in enumerate(self._scene.robots):
            self._load_robot(index, robot)
        for name, (model, state) in self._added.items():
            self._load_body(name, model, state)
        jointed = {self._bodies[name].number: arm.all_joints for name, arm in self._arms.items()}
        driven = {drive.body: drive.wheels[0] for drive in self._drives.values()}
        tie(bullet, driven | {body: joints[0] for body, joints in jointed.items()})
        self._saves = Saves(bullet)
        self._last: LastStep | None = None  # if it was gone back to
        self._stepper = Stepper(self._client, 1.0 / STEPS_PER_SECOND, self._owners, self._static, jointed)

    def _note(self, name: str, number: int, *, static: bool) -> None:
        centre, axes = self._bullet.getDynamicsInfo(number, BASE)[3:5]
        self._bodies[name] = _Body(number, static, centre, wxyz(axes))
        self._owners[number] = name
        if static:
            self._static.add(number)

    def _load_robot(self, index: int, robot: PlacedRobot) -> None:
        number, links = load_robot(self._bullet, robot)
        self._note(robot.name, number, static=robot.declaration.fixed)
        self._links[robot.name] = links.links
        group = 1 << (FIRST_ROBOT_GROUP + index)
        for link in links.shapes:
            self._bullet.setCollisionFilterGroupMask(number, link, group, ALL_GROUPS)
        wide = {links.links[name]: parts for name, parts in links.wide.items()}
        self._meeting.move(number, wide, fixed=robot.declaration.fixed)
        mobile = robot.declaration.mobile
        if mobile is not None:
            self._drives[robot.name] = PybulletDrive(self._bullet, number, links, mobile)
            self._eyes[robot.name] = _Eye(number, links.links[mobile.lidar.link], group)
        if robot.declaration.arm is not None:
            self._arms[robot.name] = PybulletArm(self._bullet, number, links, robot.declaration.arm)

    def _load_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        number = load_body(self._bullet, model, state, colour_of(name, model.colour))
        self._note(name, number, static=model.static)
        if model.static:
            self._meeting.stand(number, model.parts, state)
        else:
            self._meeting.move(number, {})
        self._place(self._bodies[name], state)

    def step(self, count: int = 1) -> int:
        """See `Engine.step`."""
        self._last = None
        made = self._stepper.make(count, [arm for arm in self._arms.values() if arm.is_moving])
        self.journal.step(made)
        return made

    def _repeat(self, count: int) -> int:
        made = self._stepper.repeat(count, [arm for arm in self._arms.values() if arm.is_moving])
        self.journal.step(made)
        return made

    def checkpoint(self) -> Checkpoint | None:
        """See `Rewinds.checkpoint`."""
        mark = self.journal.mark()
        if mark is None or self._meeting.is_twice():
            return None
        return Checkpoint(
            self._saves.take(),
            mark,
            {name: drive.command for name, drive in self._drives.items()},
            {name: arm.command for name, arm in self._arms.items()},
            self._last or self._seen_of_last_step(),
        )

    def _seen_of_last_step(self) -> LastStep:
        return LastStep(
            self.touching(),
            {name: self.touch_points(name) for name in self._links},
            {name: self.link_contacts(name) for name in self._arms},
            {name: self.joint_states(name).efforts for name in self._arms},
        )

    def rewind(self, checkpoint: Checkpoint) -> None:
        """See `Rewinds.rewind`."""
        self.journal.cut(checkpoint.mark)
        if self._stepper.is_lost or not self._saves.has(checkpoint.saved):
            # Bullet takes what has no place any more out of its world for good.
            self.restore(self.save())
            return
        self._saves.put_back(checkpoint.saved, self._movable())
        for name, told in checkpoint.drives.items():
            self._drives[name].take_up(told)
        for name, command in checkpoint.arms.items():
            self._arms[name].take_up(command)
        self._last = checkpoint.last
        self._stepper.touching = self._last.touching
        self._stepper.disturb()

    def _movable(self) -> list[int]:
        """Numbers of the bodies that move, or of which parts do."""
        return [body.number for name, body in self._bodies.items() if name in self._arms or not body.static]

    def touching(self) -> frozenset[tuple[str, str]]:
        """See `Engine.touching`."""
        return self._stepper.touching

    def touch_points(self, name: str) -> tuple[TouchPoint, ...]:
        """See `Engine.touch_points`."""
        if self._last is not None:
            return self._last.points.get(name, ())
        number, points = self._bodies[name].number, []
        arm = self._arms.get(name)
        for point in self._bullet.getContactPoints(number):
            other = self._owners[point[BODY_B]]
            if is_touching(point) and other not in (name, FLOOR):
                x, y, z = point[NORMAL]
                link = "" if arm is None else arm.link_name(point[LINK_A])
                points.append(TouchPoint(other, point[POSITION], (-x, -y, -z), link))
        return tuple(points)

    def overlaps(self, name: str) -> tuple[str, ...]:
        """See `Engine.overlaps`."""
        number = self._bodies[name].number
        others = ((other, body.number) for other, body in self._bodies.items() if other != name)
        return tuple(sorted(other for other, body in others if self._overlap(number, body)))

    def _overlap(self, first: int, second: int) -> bool:
        points = self._bullet.getClosestPoints(first, second, 0.0)
        return any(point[DISTANCE] < -OVERLAP for point in points)

    @journaled
    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        """See `Engine.add_body`."""
        self._load_body(name, model, state)
        self._added[name] = (model, state)
        self._stepper.disturb()

    @journaled
    def remove_body(self, name: str) -> None:
        """See `Engine.remove_body`."""
        number = self._bodies.pop(name).number
        self._bullet.removeBody(number)
        del self._owners[number], self._added[name]
        self._static.discard(number)
        self._meeting.remove(number)
        self._last = None
        self._stepper.disturb()

    def body_state(self, name: str) -> BodyState:
        """See `Engine.body_state`."""
        body = self._bodies[name]
        centre, turn = pybullet.getBasePositionAndOrientation(body.number, self._client)
        linear, angular = pybullet.getBaseVelocity(body.number, self._client)
        orientation = multiply(wxyz(turn), conjugate(body.axes))
        x, y, z = rotated(orientation, body.centre)
        (a, b, c), (u, v, w), (p, q, r) = centre, linear, angular
        # The velocity of the origin is that of the centre less the angular velocity times the arm between them.
        velocity = (u - q * z + r * y, v - r * x + p * z, w - p * y + q * x)
        return BodyState((a - x, b - y, c - z), orientation, velocity, angular)

    @journaled
    def set_body_state(self, name: str, state: BodyState) -> None:
        """See `Engine.set_body_state`."""
        body = self._bodies[name]
        self._place(body, state)
        self._stepper.disturb()
        if body.static:
            self._meeting.stand(body.number, self._added[name][0].parts, state)
        if name in self._drives:
            self._drives[name].stop()

    def _place(self, body: _Body, state: BodyState) -> None:
        bullet = self._bullet
        arm = rotation_matrix(state.orientation) @ body.centre
        turn = multiply(state.orientation, body.axes)
        bullet.resetBasePositionAndOrientation(body.number, _sum(state.position, arm), xyzw(turn))
        if not body.static:
            linear = _sum(state.linear, np.cross(state.angular, arm))
            bullet.resetBaseVelocity(body.number, linear, state.angular)

    def wheel_angles(self, robot: str) -> tuple[float, float]:
        """See `Engine.wheel_angles`."""
        return self._drives[robot].angles()

    def command_wheels(self, robot: str, left: float, right: float) -> None:
        """See `Engine.command_wheels`."""
        if (left, right) != self._drives[robot].command.speeds:  # most say in each tick what was said before
            self.turn_wheels(robot, left, right)

    @journaled
    def turn_wheels(self, robot: str, left: float, right: float) -> None:
        """Have motors turn the wheels at other speeds [rad/s]."""
        drive = self._drives[robot]
        drive.take_up(replace(drive.command, speeds=(left, right)))

    @journaled
    def power_wheels(self, robot: str, on: bool) -> None:
        """See `Engine.power_wheels`."""
        drive = self._drives[robot]
        drive.take_up(replace(drive.command, has_power=on))

    def cast_rays(self, robot: str, directions: Array, limit: float) -> Array:
        """See `Engine.cast_rays`."""
        eye, bullet = self._eyes[robot], self._bullet
        link = bullet.getLinkState(eye.body, eye.link, computeForwardKinematics=True)
        origin, orientation = link[4:6]
        ends = origin + limit * directions @ rotation_matrix(wxyz(orientation)).T
        hits = bullet.rayTestBatch(
            [origin] * len(ends), ends.tolist(), collisionFilterMask=ALL_GROUPS & ~eye.group
        )
        return np.array([hit[2] * limit if hit[0] >= 0 else np.inf for hit in hits])

    def joint_states(self, robot: str) -> JointStates:
        """See `Engine.joint_states`."""
        states = self._arms[robot].states()
        return states if self._last is None else replace(states, efforts=self._last.efforts[robot])

    @journaled
    def command_joints(self, robot: str, positions: Array, velocities: Array) -> None:
        """See `Engine.command_joints`."""
        self._arms[robot].command_joints(positions, velocities)
        self._stepper.disturb(RETRY)  # motors may pull hard until they are there

    @journaled
    def command_fingers(self, robot: str, position: float, force: float) -> None:
        """See `Engine.command_fingers`."""
        self._arms[robot].command_fingers(position, force)
        self._stepper.disturb(RETRY)

    def link_contacts(self, robot: str) -> frozenset[tuple[str, str]]:
        """See `Engine.link_contacts`."""
        if self._last is not None:
            return self._last.links[robot]
        return self._arms[robot].contacts(self._owners)

    def arm_overlaps(
        self, robot: str, positions: Array, own: Sequence[tuple[str, str]], carried: Carried | None
    ) -> tuple[Overlap, ...]:
        """See `Engine.arm_overlaps`."""
        parts: list[Ghost] = []
        left_out = {robot}
        if carried is not None:
            model, _ = self._added[carried.name]
            parts = self._ghosts.of(carried.name, model, carried.state)
            left_out.add(carried.name)
        others = {number: name for number, name in self._owners.items() if name not in left_out}
        return tuple(self._arms[robot].overlaps(positions, others, own, parts))

    def link_pose(self, robot: str, link: str) -> tuple[Vector, Quaternion]:
        """See `Engine.link_pose`."""
        index = self._links[robot][link]
        if index == BASE:
            state = self.body_state(robot)
            return state.position, state.orientation
        found = self._bullet.getLinkState(self._bodies[robot].number, index, computeForwardKinematics=True)
        return found[4], wxyz(found[5])

    def render(self, view: View) -> Picture:
        """See `Engine.render`."""
        return draw(self._bullet, view)


def _sum(first: Vector, second: Array) -> Vector:
    x, y, z = np.add(first, second).tolist()
    return (x, y, z)

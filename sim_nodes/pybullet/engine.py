"""The `Engine` of `sim_nodes.physics` by PyBullet.

Bullet keeps a body by its centre of mass, whose frame is turned to the principal axes of inertia; everything
here is by the origin of the body's own frame, and `_Body` has what lies between the two.

Bullet carries impulses of contacts over from step to step, which no call puts back. So a reset loads everything
anew, in the same order: a world that is reset goes on as one that was built. Its own saved states go on a little
differently, too, where many bodies touch; so a state is saved as what led to it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
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
from sim_nodes.pybullet.arm import BODY_B, DISTANCE, Ghost, Ghosts, PybulletArm, is_touching
from sim_nodes.pybullet.model import BASE, load_body, load_robot, walls_body, wheels, wxyz, xyzw
from sim_nodes.pybullet.output import caught
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
NO_SHAPE = -1  # to collide with
BEARINGS = 0.002  # [N m] of friction in wheels without power; those without any may creep on for ever


@dataclass(frozen=True)
class _Body:
    """A body: its number, and the frame of its mass in its own frame."""

    number: int
    static: bool
    centre: Vector
    axes: Quaternion


@dataclass(frozen=True)
class _Drive:
    """What a robot drives with, and sees by, in Bullet."""

    body: int
    wheels: tuple[int, int]
    lidar: int
    torque: float  # limit of the motors [N m]
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
            fixedTimeStep=1.0 / STEPS_PER_SECOND, deterministicOverlappingPairs=1, enableFileCaching=0
        )
        self._bodies: dict[str, _Body] = {}
        self._owners: dict[int, str] = {}
        self._static: set[int] = set()  # of the bodies, those that have a base which does not move
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
            self._note(name, load_body(bullet, model, BodyState((0.0, 0.0, 0.0)), WALL), static=True)
        self._drives: dict[str, _Drive] = {}
        self._commands: dict[str, tuple[float, float]] = {}  # to the wheels of robots [rad/s]
        self._without_power: set[str] = set()  # robots
        self._arms: dict[str, PybulletArm] = {}
        self._ghosts = Ghosts(bullet)
        self._links: dict[str, dict[str, int]] = {}
        for index, robot in enumerate(self._scene.robots):
            self._load_robot(index, robot)
        for name, (model, state) in self._added.items():
            self._load_body(name, model, state)
        jointed = {self._bodies[name].number: arm.all_joints for name, arm in self._arms.items()}
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
        for link in links.links.values():
            self._bullet.setCollisionFilterGroupMask(number, link, group, ALL_GROUPS)
        mobile = robot.declaration.mobile
        if mobile is not None:
            lidar = links.links[mobile.lidar.link]
            drive = _Drive(number, wheels(links, mobile.drive), lidar, mobile.drive.motor_torque, group)
            self._drives[robot.name] = drive
            self._command(robot.name, 0.0, 0.0)
        if robot.declaration.arm is not None:
            self._arms[robot.name] = PybulletArm(self._bullet, number, links, robot.declaration.arm)

    def _load_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        number = load_body(self._bullet, model, state, colour_of(name, model.colour))
        self._note(name, number, static=model.static)
        self._place(self._bodies[name], state)

    def step(self, count: int = 1) -> int:
        """See `Engine.step`."""
        made = self._stepper.make(count, [arm for arm in self._arms.values() if arm.is_moving])
        self.journal.step(made)
        return made

    def _repeat(self, count: int) -> int:
        made = self._stepper.repeat(count, [arm for arm in self._arms.values() if arm.is_moving])
        self.journal.step(made)
        return made

    def touching(self) -> frozenset[tuple[str, str]]:
        """See `Engine.touching`."""
        return self._stepper.touching

    def touch_points(self, robot: str) -> tuple[TouchPoint, ...]:
        """See `Engine.touch_points`."""
        number, points = self._bodies[robot].number, []
        for point in self._bullet.getContactPoints(number):
            other = self._owners[point[BODY_B]]
            if is_touching(point) and other not in (robot, FLOOR):
                points.append(TouchPoint(other, point[POSITION]))
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
        self._place(self._bodies[name], state)
        self._stepper.disturb()
        if name in self._drives:
            drive = self._drives[name]
            for wheel, angle in zip(drive.wheels, self.wheel_angles(name), strict=True):
                self._bullet.resetJointState(drive.body, wheel, angle, 0.0)

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
        found = self._drives[robot]
        left, right = pybullet.getJointStates(found.body, found.wheels, self._client)
        return left[0], right[0]

    def command_wheels(self, robot: str, left: float, right: float) -> None:
        """See `Engine.command_wheels`."""
        if (left, right) != self._commands[robot]:  # most say in each tick what was said before
            self.turn_wheels(robot, left, right)

    @journaled
    def turn_wheels(self, robot: str, left: float, right: float) -> None:
        """Have motors turn the wheels at other speeds [rad/s]."""
        self._command(robot, left, right)

    @journaled
    def power_wheels(self, robot: str, on: bool) -> None:
        """See `Engine.power_wheels`."""
        (self._without_power.discard if on else self._without_power.add)(robot)
        self._command(robot, *self._commands[robot])

    def _command(self, robot: str, left: float, right: float) -> None:
        self._commands[robot] = (left, right)
        drive = self._drives[robot]
        torque = drive.torque
        if robot in self._without_power:
            left, right, torque = 0.0, 0.0, BEARINGS
        self._bullet.setJointMotorControlArray(
            drive.body,
            drive.wheels,
            pybullet.VELOCITY_CONTROL,
            targetVelocities=[left, right],
            forces=[torque, torque],
        )

    def cast_rays(self, robot: str, directions: Array, limit: float) -> Array:
        """See `Engine.cast_rays`."""
        found, bullet = self._drives[robot], self._bullet
        link = bullet.getLinkState(found.body, found.lidar, computeForwardKinematics=True)
        origin, orientation = link[4:6]
        ends = origin + limit * directions @ rotation_matrix(wxyz(orientation)).T
        hits = bullet.rayTestBatch(
            [origin] * len(ends), ends.tolist(), collisionFilterMask=ALL_GROUPS & ~found.group
        )
        return np.array([hit[2] * limit if hit[0] >= 0 else np.inf for hit in hits])

    def joint_states(self, robot: str) -> JointStates:
        """See `Engine.joint_states`."""
        return self._arms[robot].states()

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

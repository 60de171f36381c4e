"""A scene in PyBullet: its bodies, their states and contacts, and its steps.

Bullet stores the pose of a body's centre of mass, with the principal axes of inertia. Everything here refers to
the origin of the body's own frame; `_Body` has the transform between them.

Bullet carries contacts over from step to step, and restores them only for the same bodies (see `rewinding.py`). So
a reset loads everything anew, in the same order: a reset world continues as a newly built one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

import numpy as np
import pybullet
from pybullet_utils.bullet_client import BulletClient

from seoro.deferred import dataclass
from sim_nodes.geometry import Quaternion, Vector, conjugate, multiply, rotated, rotation_matrix, vector
from sim_nodes.journal import Journal, journaled
from sim_nodes.physics import (
    FLOOR,
    MAX_OVERLAP,
    BodyModel,
    BodyState,
    ContactPoint,
    PlacedRobot,
    Scene,
)
from sim_nodes.pybullet import captured_output
from sim_nodes.pybullet.built_in import Weightless, pass_through
from sim_nodes.pybullet.camera import add_floor
from sim_nodes.pybullet.drives import PybulletDrive
from sim_nodes.pybullet.joints import (
    BODY_B,
    DISTANCE,
    LINK_A,
    PlacedShapes,
    PybulletArm,
    is_touching,
)
from sim_nodes.pybullet.mimic import remove_gears
from sim_nodes.pybullet.model import (
    BASE,
    link_frame,
    load_body,
    load_robot,
    movable_joints,
    wxyz,
    xyzw,
)
from sim_nodes.pybullet.planar import PlanarForces
from sim_nodes.pybullet.rays import Rays
from sim_nodes.pybullet.rewinding import AT_ONCE, BroadPhase, LastStep, StateStore, join_islands
from sim_nodes.pybullet.stepping import Stepper
from sim_nodes.pybullet.terrain import add_terrain
from sim_nodes.pybullet.textures import Textures
from sim_nodes.pybullet.work import Motors, MotorWork, WorkDone
from sim_nodes.robots.drive_declaration import PlanarDrive
from sim_nodes.robots.traction import traction_of
from sim_nodes.views import WALL, colour_of

GRAVITY = 9.81  # [m/s^2]
STEPS_PER_SECOND = 200
POSITION = 5  # field of a contact point: its position on the first body
NORMAL = 7  # field of a contact point: normal from the second body to the first


@dataclass(frozen=True)
class _Body:
    """Number of a body, and the frame of its centre of mass in its own frame."""

    number: int
    centre: Vector
    axes: Quaternion


class PybulletBodies:
    """The bodies of a scene: the part of the engine that robots, sensors and snapshots need."""

    def __init__(self) -> None:
        with captured_output():
            self._bullet: Any = BulletClient(pybullet.DIRECT)
        self._client: int = self._bullet._client  # for direct calls, without the slower wrapper

    def build(self, scene: Scene) -> None:
        """See `Engine.build`."""
        self._scene = scene
        self._added: dict[str, tuple[BodyModel, BodyState]] = {}
        self._load()

    def reset(self) -> None:
        """See `Engine.reset`."""
        self._load()

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
        self._body_states: dict[str, BodyState] = {}  # that were read since the last change
        self._owners: dict[int, str] = {}
        self._static: set[int] = set()  # numbers of the bodies with a static base
        self._jointed: dict[int, tuple[int, ...]] = {}  # joints of arms, and of bodies that have some
        self._broadphase = BroadPhase(bullet)
        self._textures = Textures(bullet)
        floor = add_floor(bullet, self._scene.extent)
        bullet.changeDynamics(floor, BASE, lateralFriction=self._scene.ground.friction)
        self._owners[floor] = FLOOR
        self._static.add(floor)
        for number, box, state in add_terrain(bullet, self._scene.ground):
            self._owners[number] = FLOOR
            self._static.add(number)
            self._broadphase.add_static(number, (box,), state)
        walls = self._scene.walls
        for name in dict.fromkeys(wall.name for wall in walls):
            parts = tuple(wall.part for wall in walls if wall.name == name)
            self._load_body(name, BodyModel(parts, static=True, colour=WALL), BodyState((0.0, 0.0, 0.0)))
        self._fixtures = tuple(self._owners)  # numbers of the floor and the walls
        self._drives: dict[str, PybulletDrive] = {}
        self._weightless = Weightless(self._client, GRAVITY)
        self._planar: dict[str, PlanarForces] = {}
        self._arms: dict[str, PybulletArm] = {}
        self._placed_shapes = PlacedShapes(bullet)
        self._links: dict[str, dict[str, int]] = {}
        self._rays = Rays(bullet)
        for robot in self._scene.robots:
            self._load_robot(robot)
        for name, (model, state) in self._added.items():
            self._load_body(name, model, state)
        jointed = {self._bodies[name].number: arm.all_joints for name, arm in self._arms.items()}
        self._jointed |= jointed
        driven = {drive.body: drive.motors[0] for drive in self._drives.values()}
        join_islands(bullet, driven | {body: joints[0] for body, joints in jointed.items()})
        self._work = MotorWork(
            self._client, 1.0 / STEPS_PER_SECOND, {name: self._motors_of(name) for name in self._links}
        )
        self._sums: list[MotorWork] = []  # once the work of a robot is measured
        self._states = StateStore(bullet)
        self._last: LastStep | None = None  # after a rewind
        self._stepper = Stepper(
            self._client,
            1.0 / STEPS_PER_SECOND,
            self._owners,
            self._static,
            self._jointed,
            (self._weightless, *self._planar.values()),
            self._sums,
        )

    def _register(self, name: str, number: int, *, static: bool) -> None:
        centre, axes = self._bullet.getDynamicsInfo(number, BASE)[3:5]
        self._bodies[name] = _Body(number, centre, wxyz(axes))
        self._owners[number] = name
        if static:
            self._static.add(number)

    def _load_robot(self, robot: PlacedRobot) -> None:
        number, links = load_robot(self._bullet, robot, self._textures)
        self._register(robot.name, number, static=robot.declaration.fixed)
        self._links[robot.name] = links.links
        self._rays.add(robot.name, number, links.shapes)
        compound = {links.links[name]: parts for name, parts in links.compound.items()}
        self._broadphase.add_moving(number, compound, fixed=robot.declaration.fixed)
        mobile = robot.declaration.mobile
        if mobile is not None:
            drive = PybulletDrive(self._bullet, number, links, mobile)
            self._drives[robot.name] = drive
            if isinstance(mobile.drive, PlanarDrive):
                traction = traction_of(robot.declaration, mobile.drive, self._scene.ground.friction)
                state = partial(self._read_state, robot.name)  # in each step
                self._planar[robot.name] = PlanarForces(
                    self._bullet, drive, traction, state, 1.0 / STEPS_PER_SECOND
                )
        if robot.declaration.arm is not None:
            self._arms[robot.name] = PybulletArm(self._bullet, number, links, robot.declaration.arm)

    def _load_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        number = load_body(self._bullet, model, state, colour_of(name, model.colour), self._textures)
        self._register(name, number, static=model.static)
        if joints := movable_joints(self._bullet, number):
            self._jointed[number] = joints
        if model.built_in:
            pass_through(self._bullet, number, self._fixtures)
            self._broadphase.ignore(number, self._fixtures)
            self._weightless.add(number, model.mass)
        if model.static and not joints:
            self._broadphase.add_static(number, model.parts, state)
        else:
            self._broadphase.add_moving(number, {}, fixed=model.static)
        self._set_state(self._bodies[name], state)

    def step(self, count: int = 1) -> int:
        """See `Engine.step`."""
        self._last = None
        return self._make_steps(self._stepper.step, count)

    def _make_steps(self, make: Callable[[int, Sequence[PybulletArm]], int], count: int) -> int:
        self._body_states = {}
        made = make(count, [arm for arm in self._arms.values() if arm.is_moving])
        self.journal.step(made)
        self._work.sample(made)
        return made

    def touching(self) -> frozenset[tuple[str, str]]:
        """See `Engine.touching`."""
        return self._stepper.touching

    def contact_points(self, name: str) -> tuple[ContactPoint, ...]:
        """See `Engine.contact_points`."""
        if self._last is not None:
            return self._last.points.get(name, ())
        number, points = self._bodies[name].number, []
        arm = self._arms.get(name)
        for point in self._bullet.getContactPoints(number):
            other = self._owners[point[BODY_B]]
            if is_touching(point) and other not in (name, FLOOR):
                x, y, z = point[NORMAL]
                link = "" if arm is None else arm.link_name(point[LINK_A])
                points.append(ContactPoint(other, point[POSITION], (-x, -y, -z), link))
        return tuple(points)

    def overlaps(self, name: str) -> tuple[str, ...]:
        """See `Engine.overlaps`."""
        number = self._bodies[name].number
        others = ((other, body.number) for other, body in self._bodies.items() if other != name)
        return tuple(sorted(other for other, body in others if self._overlap(number, body)))

    def _overlap(self, first: int, second: int) -> bool:
        points = self._bullet.getClosestPoints(first, second, 0.0)
        return any(point[DISTANCE] < -MAX_OVERLAP for point in points)

    @journaled
    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        """See `Engine.add_body`."""
        self._load_body(name, model, state)
        self._added[name] = (model, state)
        self._stepper.invalidate()

    @journaled
    def remove_body(self, name: str) -> None:
        """See `Engine.remove_body`."""
        number = self._bodies.pop(name).number
        self._body_states = {}
        remove_gears(self._bullet, number)
        if self._added[name][0].built_in:
            pass_through(self._bullet, number, self._fixtures, passes=False)
        self._bullet.removeBody(number)
        del self._owners[number], self._added[name]
        self._static.discard(number)
        self._jointed.pop(number, None)
        self._weightless.remove(number)
        self._broadphase.remove(number)
        self._last = None
        self._stepper.invalidate()

    def body_state(self, name: str) -> BodyState:
        """See `Engine.body_state`."""
        state = self._body_states.get(name)
        if state is None:
            state = self._body_states[name] = self._read_state(name)
        return state

    def _read_state(self, name: str) -> BodyState:
        body = self._bodies[name]
        position, orientation, (x, y, z) = self._frame(body)
        (u, v, w), angular = pybullet.getBaseVelocity(body.number, self._client)
        p, q, r = angular
        # Velocity of the origin: that of the centre minus angular velocity times the arm between them.
        velocity = (u - q * z + r * y, v - r * x + p * z, w - p * y + q * x)
        return BodyState(position, orientation, velocity, angular)

    def _frame(self, body: _Body) -> tuple[Vector, Quaternion, Vector]:
        """Return position [m] and orientation of a body, and the arm from its origin to the centre of mass [m]."""
        (a, b, c), turn = pybullet.getBasePositionAndOrientation(body.number, self._client)
        orientation = multiply(wxyz(turn), conjugate(body.axes))
        x, y, z = rotated(orientation, body.centre)
        return (a - x, b - y, c - z), orientation, (x, y, z)

    @journaled
    def set_body_state(self, name: str, state: BodyState) -> None:
        """See `Engine.set_body_state`."""
        body = self._bodies[name]
        self._set_state(body, state)
        self._stepper.invalidate()
        if body.number in self._static and body.number not in self._jointed:
            self._broadphase.add_static(body.number, self._added[name][0].parts, state)
        if name in self._drives:
            self._drives[name].stop()
        self._work.read_speeds()

    def _set_state(self, body: _Body, state: BodyState) -> None:
        bullet = self._bullet
        self._body_states = {}
        arm = rotation_matrix(state.orientation) @ body.centre
        turn = multiply(state.orientation, body.axes)
        bullet.resetBasePositionAndOrientation(body.number, vector(np.add(state.position, arm)), xyzw(turn))
        if body.number not in self._static:
            linear = vector(np.add(state.linear, np.cross(state.angular, arm)))
            bullet.resetBaseVelocity(body.number, linear, state.angular)

    def _motors_of(self, robot: str) -> Motors:
        drive, arm = self._drives.get(robot), self._arms.get(robot)
        joints = (*(drive.motors if drive is not None else ()), *(arm.all_joints if arm is not None else ()))

        def is_commanded() -> bool:
            return (drive is not None and drive.is_commanded) or (arm is not None and arm.is_moving)

        return Motors(self._bodies[robot].number, joints, self._planar.get(robot), is_commanded)

    def _resume_work(self, done: WorkDone) -> None:
        self._work.resume(done)
        self._sums[:] = [self._work] if done.measured else []

    def link_contacts(self, robot: str) -> frozenset[tuple[str, str]]:
        """See `Engine.link_contacts`."""
        if self._last is not None:
            return self._last.links[robot]
        return self._arms[robot].contacts(self._owners)

    def link_pose(self, robot: str, link: str) -> tuple[Vector, Quaternion]:
        """See `Engine.link_pose`."""
        return link_frame(self._bullet, self._bodies[robot].number, self._links[robot][link])

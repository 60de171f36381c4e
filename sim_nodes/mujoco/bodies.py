"""A scene in MuJoCo: its bodies, their states and contacts, and its steps.

Adding or removing bodies recompiles the specification, which keeps all other states exactly. The model and data
are new then, so `_bind` looks up everything that refers to them.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import Any

import mujoco

from sim_nodes.geometry import Array, rotated, rotation_matrix, vector
from sim_nodes.mujoco.arm import MujocoArm
from sim_nodes.mujoco.driven import DrivenBodies
from sim_nodes.mujoco.drives import DriveAddresses
from sim_nodes.mujoco.files import detach_file
from sim_nodes.mujoco.joint_values import JointValues
from sim_nodes.mujoco.model import WALL_PREFIX, add_body, scene_spec
from sim_nodes.mujoco.rays import Rays
from sim_nodes.mujoco.stepping import LastStep, Stepper
from sim_nodes.mujoco.terrain import TERRAIN_BODY
from sim_nodes.mujoco.work import MotorWork
from sim_nodes.physics import FLOOR, MAX_OVERLAP, BodyModel, BodyState, ContactPoint, Scene


class MujocoBodies:
    """The bodies of a scene: the part of the engine that robots, sensors and snapshots need."""

    def build(self, scene: Scene) -> None:
        """See `Engine.build`."""
        self._scene = scene
        self._added: dict[str, tuple[BodyModel, BodyState]] = {}
        self._spec = scene_spec(scene)
        self._model = self._spec.compile()
        self._data = mujoco.MjData(self._model)
        self._start()

    def _start(self) -> None:
        """Bind a new state, and set arms to their initial positions."""
        self._arms: dict[str, MujocoArm] = {}
        self._without_power: set[str] = set()  # robots
        self._work = MotorWork(self._model, self._data, self._robots)
        self._bind()
        for arm in self._arms.values():
            arm.go_home(self._data)
        if self._arms:
            mujoco.mj_forward(self._model, self._data)
        self._set_velocities(self._added)
        self._forget_states()

    def _bind(self) -> None:
        model = self._model
        mujoco.mj_forward(model, self._data)
        self._bases = {
            robot.name: model.body(f"{robot.name}/{robot.declaration.base_link}").id
            for robot in self._scene.robots
        }
        self._drives = {
            robot.name: DriveAddresses(model, robot.name, self._bases[robot.name], robot.declaration, mobile)
            for robot in self._scene.robots
            if (mobile := robot.declaration.mobile) is not None
        }
        for name, drive in self._drives.items():
            drive.power(model, on=name not in self._without_power)
        commands = {name: arm.command for name, arm in self._arms.items()}
        self._arms = {
            robot.name: MujocoArm(
                model,
                robot.name,
                robot.declaration.arm,
                robot.declaration.urdf,
                commands.get(robot.name),
                hangs_on_base=robot.declaration.mobile is not None,
            )
            for robot in self._scene.robots
            if robot.declaration.arm is not None
        }
        self._bases |= {name: model.body(name).id for name in self._added}
        joints = {name: _free_joint(model, body) for name, body in self._bases.items()}
        self._free_joints = {name: addresses for name, addresses in joints.items() if addresses is not None}
        self._driven = DrivenBodies(model, self._bases, self._added)
        names = {base: name for name, base in self._bases.items()}
        if not self._scene.ground.is_flat:
            names[model.body(TERRAIN_BODY).id] = FLOOR
        roots = model.body_rootid[model.geom_bodyid]
        self._owners = [
            names[int(root)] if root else _static_owner(model.geom(geom).name) for geom, root in enumerate(roots)
        ]
        self._stepper = Stepper(model, self._data, self._owners, self._work)
        self._rays = Rays(model, self._data)
        self._links: dict[tuple[str, str], int] = {}  # bodies of links that cast rays
        self._prediction: Any = None  # second data, for predicted overlaps
        self._last: LastStep | None = None
        self._forget_states()

    @property
    def _robots(self) -> tuple[str, ...]:
        return tuple(robot.name for robot in self._scene.robots)

    def _forget_states(self) -> None:
        """Drop cached states, values and frames, because positions or velocities change."""
        self._states: dict[str, BodyState] = {}
        self._values = JointValues(self._data)
        self._is_placed = False  # whether the frames of all bodies are those of the present positions

    def _place_bodies(self) -> None:
        """Update the frames of bodies, which are those before the last step after it."""
        if not self._is_placed:
            mujoco.mj_kinematics(self._model, self._data)
            self._is_placed = True

    def reset(self) -> None:
        """See `Engine.reset`."""
        mujoco.mj_resetData(self._model, self._data)
        self._start()

    def step(self, count: int = 1) -> int:
        """See `Engine.step`."""
        self._last = None
        self._forget_states()
        return self._stepper.step(count, [arm for arm in self._arms.values() if arm.is_moving])

    def touching(self) -> frozenset[tuple[str, str]]:
        """See `Engine.touching`."""
        return self._stepper.touching

    def contact_points(self, name: str) -> tuple[ContactPoint, ...]:
        """See `Engine.contact_points`."""
        contact, points = self._data.contact, []
        links = self._arms[name].links if name in self._arms else {}
        for geoms, place, frame in zip(contact.geom.tolist(), contact.pos, contact.frame, strict=True):
            owners = (self._owners[geoms[0]], self._owners[geoms[1]])
            if name in owners and FLOOR not in owners and owners != (name, name):
                other = int(owners[0] == name)
                normal = vector(frame[:3] if other else -frame[:3])
                points.append(ContactPoint(owners[other], vector(place), normal, links.get(geoms[1 - other], "")))
        return tuple(points)

    def overlaps(self, name: str) -> tuple[str, ...]:
        """See `Engine.overlaps`."""
        solid = [geom for geom in range(self._model.ngeom) if self._model.geom_contype[geom]]
        own = [geom for geom in solid if self._owners[geom] == name]
        others = [geom for geom in solid if self._owners[geom] not in (name, FLOOR)]
        return tuple(
            sorted({self._owners[other] for mine in own for other in others if self._penetrates(mine, other)})
        )

    def _penetrates(self, first: int, second: int) -> bool:
        return bool(
            mujoco.mj_geomDistance(self._model, self._data, first, second, MAX_OVERLAP, None) < -MAX_OVERLAP
        )

    def add_body(self, name: str, model: BodyModel, state: BodyState) -> None:
        """See `Engine.add_body`."""
        self.add_bodies([(name, model, state)])

    def add_bodies(self, bodies: Sequence[tuple[str, BodyModel, BodyState]]) -> None:
        """See `ManyBodies.add_bodies`."""
        for name, model, state in bodies:
            add_body(self._spec, name, model, state)
            self._added[name] = (model, state)
        self._recompile()
        self._set_velocities(name for name, _, _ in bodies)

    def _set_velocities(self, names: Iterable[str]) -> None:
        """Set the initial velocities of bodies, which a specification cannot hold."""
        for name in names:
            model, state = self._added[name]
            if not model.static and any((*state.linear, *state.angular)):
                self.set_body_state(name, state)

    def remove_body(self, name: str) -> None:
        """See `Engine.remove_body`."""
        self.remove_bodies([name])

    def remove_bodies(self, names: Sequence[str]) -> None:
        """See `ManyBodies.remove_bodies`."""
        for name in names:
            self._spec.delete(self._spec.body(name))
            detach_file(self._spec, name)
            del self._added[name]
        self._recompile()

    def _recompile(self) -> None:
        self._model, self._data = self._spec.recompile(self._model, self._data)
        work = MotorWork(self._model, self._data, self._robots)
        work.resume(self._work.done)
        self._work = work
        self._bind()

    def body_state(self, name: str) -> BodyState:
        """See `Engine.body_state`."""
        state = self._states.get(name)
        if state is None:
            state = self._states[name] = self._read_state(name)
        return state

    def _read_state(self, name: str) -> BodyState:
        addresses = self._free_joints.get(name)
        if addresses is None:
            body, data = self._bases[name], self._data
            return BodyState(vector(data.xpos[body]), tuple(data.xquat[body].tolist()))
        position, speed = addresses
        x, y, z, w, i, j, k = self._values.positions[position : position + 7]
        vx, vy, vz, p, q, r = self._values.speeds[speed : speed + 6]
        # The angular velocity of a free joint is in the body's frame; data.xmat is that before the last step.
        return BodyState((x, y, z), (w, i, j, k), (vx, vy, vz), rotated((w, i, j, k), (p, q, r)))

    def set_body_state(self, name: str, state: BodyState) -> None:
        """See `Engine.set_body_state`."""
        body, data = self._bases[name], self._data
        mocap = self._model.body_mocapid[body]
        if mocap >= 0:
            data.mocap_pos[mocap] = state.position
            data.mocap_quat[mocap] = state.orientation
        else:
            joint = self._model.body_jntadr[body]
            position, speed = self._model.jnt_qposadr[joint], self._model.jnt_dofadr[joint]
            data.qpos[position : position + 7] = [*state.position, *state.orientation]
            data.qvel[speed : speed + 3] = state.linear
            data.qvel[speed + 3 : speed + 6] = rotation_matrix(state.orientation).T @ state.angular
        if name in self._drives:
            data.qvel[self._drives[name].wheel_angular_speeds] = 0.0
        self._last = None
        self._forget_states()
        mujoco.mj_forward(self._model, data)

    def driven_poses(self) -> Array:
        """See `DrivesBodies.driven_poses`."""
        return self._driven.poses(self._data)

    def drive_bodies(self, velocities: Array, heights: Array) -> None:
        """See `DrivesBodies.drive_bodies`."""
        self._driven.drive(self._data, velocities, heights)
        self._forget_states()


def _free_joint(model: Any, body: int) -> tuple[int, int] | None:
    """Return the addresses of position and speed of a body's free joint; None if it has none."""
    if not model.body_dofnum[body]:
        return None
    joint = model.body_jntadr[body]
    return int(model.jnt_qposadr[joint]), int(model.jnt_dofadr[joint])


def _static_owner(geom: str) -> str:
    """Return the entity of a geom of the world body."""
    return geom.split("/")[1] if geom.startswith(WALL_PREFIX) else FLOOR

"""Implements `Engine` with MuJoCo: robots, sensors and saved states of a scene."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import mujoco

from sim_nodes.geometry import Array, Quaternion, Vector, vector
from sim_nodes.mujoco.arm import ArmCommand, outside_overlaps, own_overlaps
from sim_nodes.mujoco.bodies import MujocoBodies
from sim_nodes.mujoco.camera import Renderer
from sim_nodes.mujoco.model import TIMESTEP, load_sensors
from sim_nodes.mujoco.rays import Cast
from sim_nodes.mujoco.stepping import LastStep, Stepper, digest_of, set_state, state_of
from sim_nodes.physics import CarriedBody, JointStates, Overlap, UnsavableState
from sim_nodes.ray_bundles import RayBundle
from sim_nodes.views import DepthImage, Picture, View


class MujocoEngine(MujocoBodies):
    """MuJoCo with one scene; implements `sim_nodes.physics.Engine`."""

    name = "mujoco"
    version: str = mujoco.__version__
    steps_per_second = round(1.0 / TIMESTEP)

    def __init__(self) -> None:
        self._renderer: Renderer | None = None

    def save(self) -> Mapping[str, Any]:
        """See `SavesState.save`."""
        if self._stepper.has_diverged:
            raise UnsavableState("the physics has diverged: reset the simulation")
        return {**self.checkpoint(), "added": self._added, "model": digest_of(self._model)}

    def checkpoint(self) -> Mapping[str, Any]:
        """See `Rewinds.checkpoint`."""
        links = {name: self.link_contacts(name) for name in self._arms}
        return {
            "state": state_of(self._model, self._data),
            "without_power": set(self._without_power),
            "arms": {name: (arm.command.rates.copy(), arm.command.force) for name, arm in self._arms.items()},
            "last": LastStep(self.touching(), links, self._data.qfrc_actuator.copy()),
            "work": self._work.done,
        }

    def restore(self, saved: Mapping[str, Any]) -> None:
        """See `SavesState.restore`."""
        self.build(self._scene)
        self.add_bodies([(name, model, state) for name, (model, state) in saved["added"].items()])
        self._apply_commands(saved)
        if digest_of(self._model) != saved["model"]:
            raise UnsavableState("the saved state has other robots, walls or bodies than the present files")
        self._set_state(saved)

    def rewind(self, checkpoint: Mapping[str, Any]) -> None:
        """See `Rewinds.rewind`."""
        self._apply_commands(checkpoint)
        self._set_state(checkpoint)

    def _apply_commands(self, checkpoint: Mapping[str, Any]) -> None:
        """Restore the commands that change the model."""
        self._without_power = set(checkpoint["without_power"])
        for name, drive in self._drives.items():
            drive.power(self._model, on=name not in self._without_power)
        for name, (rates, force) in checkpoint["arms"].items():
            self._arms[name].apply_command(self._model, ArmCommand(rates.copy(), force))

    def _set_state(self, checkpoint: Mapping[str, Any]) -> None:
        """Set the state of a checkpoint."""
        set_state(self._model, self._data, checkpoint["state"])
        self._last = checkpoint["last"]
        self._work.resume(checkpoint["work"])
        self._stepper = Stepper(self._model, self._data, self._owners, self._work, self._last.touching)
        self._data.qfrc_actuator[:] = self._last.efforts
        self._forget_states()

    def wheel_angles(self, robot: str) -> tuple[float, ...]:
        """See `Engine.wheel_angles`."""
        positions = self._values.positions
        return tuple([positions[at] for at in self._drives[robot].wheel_positions])

    def command_wheels(self, robot: str, *targets: float) -> None:
        """See `Engine.command_wheels`."""
        drive, controls = self._drives[robot], self._data.ctrl
        for motor, target in zip(drive.motors, targets, strict=True):
            controls[motor] = target
        if drive.planar is not None:
            drive.planar.command(self._data, targets)

    def power_wheels(self, robot: str, on: bool) -> None:
        """See `Engine.power_wheels`."""
        self._work.read()
        (self._without_power.discard if on else self._without_power.add)(robot)
        self._drives[robot].power(self._model, on=on)

    def motor_work(self, robot: str) -> float:
        """See `MeasuresWork.motor_work`."""
        return self._work.total(robot)

    def measure_work(self, robot: str) -> None:
        """See `MeasuresWork.measure_work`; the work of all robots is always exact."""

    def cast_rays(
        self, robot: str, link: str, directions: Array, limit: float, position: Vector = (0.0, 0.0, 0.0)
    ) -> Array:
        """See `Engine.cast_rays`."""
        return self.cast_together([RayBundle(robot, link, directions, limit, position)])[0]

    def cast_together(self, bundles: Sequence[RayBundle]) -> list[Array]:
        """See `CastsTogether.cast_together`."""
        self._place_bodies()
        return self._rays.cast([Cast(each, self._link(each), self._bases[each.robot]) for each in bundles])

    def _link(self, bundle: RayBundle) -> int:
        robot, link = bundle.robot, bundle.link
        body = self._links.get((robot, link))
        if body is None:
            body = self._links[robot, link] = self._model.body(f"{robot}/{link}").id
        return body

    def joint_states(self, robot: str) -> JointStates:
        """See `Engine.joint_states`."""
        return self._arms[robot].states(self._data)

    def command_joints(self, robot: str, positions: Array, velocities: Array) -> None:
        """See `Engine.command_joints`."""
        self._arms[robot].command_joints(self._data, positions, velocities)

    def command_fingers(self, robot: str, position: float, force: float) -> None:
        """See `Engine.command_fingers`."""
        self._work.read()
        self._arms[robot].command_fingers(self._model, self._data, position, force)

    def link_contacts(self, robot: str) -> frozenset[tuple[str, str]]:
        """See `Engine.link_contacts`."""
        if self._last is not None:
            return self._last.links[robot]
        touched = outside_overlaps(self._data, self._arms[robot], self._owners, None)
        return frozenset((overlap.link, overlap.other) for overlap in touched)

    def arm_overlaps(
        self, robot: str, positions: Array, own: Sequence[tuple[str, str]], carried: CarriedBody | None
    ) -> tuple[Overlap, ...]:
        """See `Engine.arm_overlaps`."""
        model, arm = self._model, self._arms[robot]
        if self._prediction is None:
            self._prediction = mujoco.MjData(model)
        thought = self._prediction
        for values, present in ((thought.qpos, self._data.qpos), (thought.mocap_pos, self._data.mocap_pos)):
            values[:] = present
        thought.mocap_quat[:] = self._data.mocap_quat
        arm.set_positions(thought, positions)
        if carried is not None:
            joint = model.body_jntadr[self._bases[carried.name]]
            place = model.jnt_qposadr[joint]
            thought.qpos[place : place + 7] = [*carried.state.position, *carried.state.orientation]
        mujoco.mj_kinematics(model, thought)
        mujoco.mj_collision(model, thought)
        name = None if carried is None else carried.name
        return (*outside_overlaps(thought, arm, self._owners, name), *own_overlaps(model, thought, arm, own))

    def link_pose(self, robot: str, link: str) -> tuple[Vector, Quaternion]:
        """See `Engine.link_pose`."""
        self._place_bodies()
        body = self._model.body(f"{robot}/{link}").id
        w, i, j, k = self._data.xquat[body].tolist()
        return vector(self._data.xpos[body]), (w, i, j, k)

    def joint_load(self, robot: str, link: str) -> tuple[Vector, Vector]:
        """See `Engine.joint_load`."""
        first, second = (self._model.sensor(f"{robot}/{name}").adr[0] for name in load_sensors(link))
        readings = self._data.sensordata
        # MuJoCo measures the force on the link.
        return vector(-readings[first : first + 3]), vector(-readings[second : second + 3])

    def render_depth(self, view: View) -> DepthImage:
        """See `Engine.render_depth`."""
        return self._made_renderer().measure(self._model, self._data, view, self._owners)

    def render(self, view: View) -> Picture:
        """See `Engine.render`."""
        return self._made_renderer().draw(self._model, self._data, view)

    def _made_renderer(self) -> Renderer:
        if self._renderer is None:
            self._renderer = Renderer()
        return self._renderer

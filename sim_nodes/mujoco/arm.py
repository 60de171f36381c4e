"""Arms in MuJoCo: their motors in a specification, and their joints in the arrays of a model."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import combinations
from typing import Any

import mujoco
import numpy as np
from defusedxml import ElementTree

from seoro.deferred import dataclass
from sim_nodes.geometry import Array
from sim_nodes.models.urdf import mimics_of
from sim_nodes.physics import JointStates, Overlap
from sim_nodes.robots.declaration import ArmDeclaration, GripperDeclaration

IMPRATIO = 10.0  # ratio of frictional to normal impedance; with less, held objects creep out of the fingers
ROLLING = 0.0001
STIFF_CONTACT = 0.01  # [s], half of MuJoCo's default, with which fingers sink into held objects by millimetres
# For links that follow a finger: time constant [s] and damping ratio, and MuJoCo's five numbers of the impedance.
STIFF_COUPLING = ([0.01, 1.0], [0.99, 0.999, 0.001, 0.5, 2.0])
TORSIONAL_CONTACT = 4  # dimensions of a contact with torsional friction


def configure_grip_contacts(spec: Any) -> None:
    """Set the contact options that keep held objects from slipping."""
    spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
    spec.option.impratio = IMPRATIO


def add_arm(spec: Any, arm: ArmDeclaration, *, fixed: bool) -> None:
    """Add the motors of position-controlled joints; links do not collide with each other.

    Gravity is compensated for fixed arms, as their own controllers do, and their paths are checked for collisions.
    Targets of the motors compensate it for arms on a base, which has to carry their weight.
    """
    for declared in arm.joints:
        joint = spec.joint(declared.name)
        joint.armature, joint.actgravcomp = declared.armature, True
        motor = spec.add_actuator(name=declared.name, target=declared.name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_position(kp=declared.stiffness, kv=declared.damping)
    if arm.gripper is not None:
        _add_gripper(spec, arm.gripper)
    bodies = [body for body in spec.bodies if body.name != "world"]
    if arm.tool_link is not None and fixed:
        for body in bodies:
            body.gravcomp = 1.0
    for first, second in combinations(bodies, 2):
        spec.add_exclude(bodyname1=first.name, bodyname2=second.name)


def _add_gripper(spec: Any, gripper: GripperDeclaration) -> None:
    for name in gripper.joints:
        spec.joint(name).armature = gripper.armature
        motor = spec.add_actuator(name=name, target=name, trntype=mujoco.mjtTrn.mjTRN_JOINT)
        motor.set_to_position(kp=gripper.stiffness, kv=gripper.damping)
        motor.forcelimited = True
        effort = gripper.effort_of(gripper.max_force)
        motor.forcerange = [-effort, effort]
    couplings = [each for each in spec.equalities if each.type == mujoco.mjtEq.mjEQ_JOINT]
    for coupling in couplings if gripper.turning is not None else ():
        coupling.solref, coupling.solimp = STIFF_COUPLING
        if coupling.name1 not in gripper.joints:
            spec.joint(coupling.name1).armature = gripper.armature
    for link in gripper.links:
        for geom in spec.body(link).geoms:
            geom.friction = [gripper.friction, gripper.torsional_friction, ROLLING]
            geom.condim = TORSIONAL_CONTACT
            geom.solref = [STIFF_CONTACT, 1.0]


@dataclass
class ArmCommand:
    """The last command of an arm, beyond the state of MuJoCo."""

    rates: Array  # velocities of the joint targets [rad/s]
    force: float  # of the fingers [N]


class MujocoArm:
    """The joints and links of an arm in a model.

    Args:
        model: The model.
        robot: Name of the robot that has the arm.
        arm: Declaration of the arm.
        urdf: Canonical URDF of the robot.
        command: The last command; None at the start.
        hangs_on_base: Whether the weight of the arm acts on a base that moves.
    """

    def __init__(
        self,
        model: Any,
        robot: str,
        arm: ArmDeclaration,
        urdf: str,
        command: ArmCommand | None,
        *,
        hangs_on_base: bool,
    ) -> None:
        self._arm = arm
        self._weights = Weights(model) if hangs_on_base else None
        self._compliance = np.array([1.0 / joint.stiffness for joint in arm.joints])  # [rad/(N m)], [m/N]
        prefix = f"{robot}/"
        names = [joint.name for joint in arm.joints]
        joints = [model.joint(prefix + name) for name in (*names, *arm.fingers)]
        motors = [model.actuator(joint.name).id for joint in joints]
        self._positions = np.array([int(joint.qposadr[0]) for joint in joints])
        self._speeds = np.array([int(joint.dofadr[0]) for joint in joints])
        self._motors, self._fingers = np.array(motors[: len(names)]), np.array(motors[len(names) :], dtype=np.intp)
        self._lead = np.array([joint.damping / joint.stiffness for joint in arm.joints])  # [s]
        self.command = command or ArmCommand(
            np.zeros(len(names)), 0.0 if arm.gripper is None else arm.gripper.effort_of(arm.gripper.max_force)
        )
        self._limit_force(model, self.command.force)
        self._followers = _followers(model, prefix, urdf, arm.fingers)
        bodies = {body: model.body(body).name for body in range(model.nbody)}
        own = {body: name.removeprefix(prefix) for body, name in bodies.items() if name.startswith(prefix)}
        self.links = {
            geom: own[int(body)]
            for geom, body in enumerate(model.geom_bodyid)
            if int(body) in own and model.geom_contype[geom]
        }

    def apply_command(self, model: Any, command: ArmCommand) -> None:
        """Restore the command that belongs to a restored state of MuJoCo."""
        self.command = command
        self._limit_force(model, command.force)

    def go_home(self, data: Any) -> None:
        """Set the joints to their initial positions, and make the motors hold them."""
        home = np.array([joint.home for joint in self._arm.joints])
        gripper = self._arm.gripper
        finger = 0.0 if gripper is None else gripper.position_of(gripper.stroke)
        data.qpos[self._positions] = [*home, *(finger for _ in self._arm.fingers)]
        for follower, leader, offset, factor in self._followers:
            data.qpos[follower] = offset + factor * data.qpos[leader]
        data.ctrl[self._motors] = self._lifted(data, home)
        data.ctrl[self._fingers] = finger

    def set_positions(self, data: Any, positions: Array) -> None:
        """Set the positions of the arm's joints; the fingers keep theirs."""
        data.qpos[self._positions[: len(positions)]] = positions

    def states(self, data: Any) -> JointStates:
        """See `Engine.joint_states`."""
        positions, speeds = data.qpos[self._positions], data.qvel[self._speeds]
        return JointStates(positions, speeds, data.qfrc_actuator[self._speeds])

    def command_joints(self, data: Any, positions: Array, velocities: Array) -> None:
        """See `Engine.command_joints`."""
        # The motors damp the total velocity; with this lead, they damp its difference from the target velocity.
        data.ctrl[self._motors] = self._lifted(data, positions + self._lead * velocities)
        self.command.rates = velocities

    def _lifted(self, data: Any, targets: Array) -> Array:
        """Return targets of the motors at which they hold the weight of an arm on a base [rad], [m]."""
        if self._weights is None:
            return targets
        weights: Array = self._weights.at(data)[self._speeds[: len(targets)]]
        return targets + self._compliance * weights

    def command_fingers(self, model: Any, data: Any, position: float, force: float) -> None:
        """See `Engine.command_fingers`."""
        self.command.force = force
        self._limit_force(model, force)
        data.ctrl[self._fingers] = position

    @property
    def is_moving(self) -> bool:
        """Whether the joint targets move."""
        return bool(self.command.rates.any())

    def advance_targets(self, data: Any, time: float) -> None:
        """Advance the joint targets by a duration [s]."""
        data.ctrl[self._motors] += time * self.command.rates

    def _limit_force(self, model: Any, force: float) -> None:
        model.actuator_forcerange[self._fingers] = (-force, force)


@cache
def _mimics(urdf: str) -> Mapping[str, tuple[str, float, float]]:
    return mimics_of(ElementTree.fromstring(urdf))


def _followers(model: Any, prefix: str, urdf: str, without: Sequence[str]) -> list[tuple[int, int, float, float]]:
    """Return the joints of a robot that follow others: addresses of both, offset and factor."""
    found = []
    for name, (leader, factor, offset) in _mimics(urdf).items():
        if name not in without:
            follower, driven = (int(model.joint(prefix + each).qposadr[0]) for each in (name, leader))
            found.append((follower, driven, offset, factor))
    return found


class Weights:
    """Forces of joints that hold the weight of all bodies of a model at rest.

    Args:
        model: The model.
    """

    def __init__(self, model: Any) -> None:
        self._model, self._still = model, mujoco.MjData(model)
        self._forces = np.zeros(model.nv)

    def at(self, data: Any) -> Array:
        """Return the forces by degree of freedom [N m], [N], at the present positions; a view."""
        self._still.qpos[:] = data.qpos
        mujoco.mj_kinematics(self._model, self._still)
        mujoco.mj_comPos(self._model, self._still)
        mujoco.mj_rne(self._model, self._still, 0, self._forces)
        return self._forces


def outside_overlaps(data: Any, arm: MujocoArm, owners: Sequence[str], carried: str | None) -> list[Overlap]:
    """Return overlaps of an arm's links and its carried body with other entities, by the contacts in `data`."""
    found = []
    # As arrays: iterating over the contacts one by one takes as long as for the full buffer.
    for (first, second), distance in zip(data.contact.geom.tolist(), data.contact.dist.tolist(), strict=True):
        for mine, other in ((first, second), (second, first)):
            if carried is not None and owners[mine] == carried:
                found.append(Overlap(carried, arm.links.get(other, owners[other]), -distance))
            elif mine in arm.links and other not in arm.links and owners[other] != carried:
                found.append(Overlap(arm.links[mine], owners[other], -distance))
    return found


def own_overlaps(model: Any, data: Any, arm: MujocoArm, pairs: Sequence[tuple[str, str]]) -> list[Overlap]:
    """Return the overlaps between given pairs of links of an arm."""
    geoms: dict[str, list[int]] = {}
    for geom, link in arm.links.items():
        geoms.setdefault(link, []).append(geom)
    found = []
    for first, second in pairs:
        touching = (
            mujoco.mj_geomDistance(model, data, mine, other, 0.0, None)
            for mine in geoms[first]
            for other in geoms[second]
        )
        depth = -min(touching)
        if depth > 0.0:
            found.append(Overlap(first, second, depth))
    return found

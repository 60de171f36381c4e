"""Arms in PyBullet: motors of their joints, and contacts of their links.

Links of an arm do not collide with each other, which is Bullet's default: paths are checked for that before the
arm moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, assert_never

import numpy as np
import pybullet

from seoro.deferred import dataclass
from sim_nodes.geometry import Array, multiply, rotation_matrix
from sim_nodes.physics import (
    BodyModel,
    BodyState,
    Box,
    Capsule,
    Cylinder,
    Hull,
    JointStates,
    Overlap,
    Shape,
    Sphere,
)
from sim_nodes.pybullet.model import BASE, JOINT_TYPE, Links, xyzw
from sim_nodes.robots.declaration import ArmDeclaration, GripperDeclaration

# Fields of the results of getContactPoints and getClosestPoints.
BODY_A, BODY_B, LINK_A, LINK_B, DISTANCE, FORCE = 1, 2, 3, 4, 8, 9
MASS = 0  # field of the results of getDynamicsInfo: 0 for a base that never moves
PARENT = 16  # field of the results of getJointInfo: index of the parent link
INERTIA = 2  # field of the results of getDynamicsInfo: principal moments
DAMPING = 6  # field of the results of getJointInfo
MAX_FORCE = 10  # field of the results of getJointInfo: the effort limit of the URDF
POSITION_GAIN, VELOCITY_GAIN = 0.3, 1.0  # shares of an error that a motor corrects in one step
FINGER_GAIN = 0.1
COUPLING_FORCE, COUPLING_ERROR_REDUCTION = 1000.0, 0.2  # of the gear constraint of the fingers [N]


def is_touching(point: Sequence[Any]) -> bool:
    """Whether a contact point touches; Bullet also returns points up to 2 cm apart."""
    return bool(point[DISTANCE] <= 0.0 or point[FORCE] > 0.0)


@dataclass(frozen=True)
class ArmCommand:
    """The last command of an arm.

    Attributes:
        targets: Target positions of the joints [rad].
        rates: Velocities of the targets [rad/s].
        fingers: Target position of the fingers [m], and maximum force of each [N].
    """

    targets: Array
    rates: Array
    fingers: tuple[float, float]


class PybulletArm:
    """The joints and links of an arm.

    Args:
        bullet: The Bullet client.
        body: Number of the robot's body.
        links: Its links and joints.
        arm: Declaration of the arm.

    Attributes:
        all_joints: Numbers of the joints of the arm and the fingers.
    """

    def __init__(self, bullet: Any, body: int, links: Links, arm: ArmDeclaration) -> None:
        self._bullet, self._body = bullet, body
        self._links = {number: name for name, number in links.links.items()}
        self._numbers = links.links
        self._still = _still_links(bullet, body)
        self._joints = [links.joints[joint.name] for joint in arm.joints]
        self._fingers = [links.joints[name] for name in arm.fingers]
        self.all_joints = (*self._joints, *self._fingers)
        self._undamp_light_joints()
        self._torques = [bullet.getJointInfo(body, joint)[MAX_FORCE] for joint in self._joints]
        home = np.array([joint.home for joint in arm.joints])
        self.set_positions(home)
        self._grip = (0.0, 0.0)
        if arm.gripper is not None:
            self._add_gripper(arm.gripper)
        self.command_joints(home, np.zeros(len(home)))
        if arm.gripper is not None:
            gripper = arm.gripper
            self.command_fingers(gripper.position_of(gripper.stroke), gripper.effort_of(gripper.max_force))

    def _add_gripper(self, gripper: GripperDeclaration) -> None:
        """Open the gripper, and give its fingers their friction."""
        bullet, body = self._bullet, self._body
        finger = gripper.position_of(gripper.stroke)
        for joint in self._fingers:
            bullet.resetJointState(body, joint, finger)
        for name in gripper.links:
            bullet.changeDynamics(
                body,
                self._numbers[name],
                lateralFriction=gripper.friction,
                spinningFriction=gripper.torsional_friction,
                # Without, friction acts on velocities only: fast moved objects slip by millimetres.
                frictionAnchor=True,
            )
        self._couple_fingers()

    def _couple_fingers(self) -> None:
        """Keep the fingers at equal positions by a gear; Bullet ignores `mimic`."""
        left, right = self._fingers
        gear = self._bullet.createConstraint(
            self._body, left, self._body, right, pybullet.JOINT_GEAR, [1, 0, 0], [0, 0, 0], [0, 0, 0]
        )
        self._bullet.changeConstraint(gear, gearRatio=-1, maxForce=COUPLING_FORCE, erp=COUPLING_ERROR_REDUCTION)

    def _undamp_light_joints(self) -> None:
        """Remove the damping of joints whose links it would stop within a step.

        Bullet applies damping explicitly, so more than inertia divided by step makes light links tremble. Motors
        damp them as well.
        """
        step = self._bullet.getPhysicsEngineParameters()["fixedTimeStep"]
        for joint in self._joints:
            damping = self._bullet.getJointInfo(self._body, joint)[DAMPING]
            if damping * step > max(self._bullet.getDynamicsInfo(self._body, joint)[INERTIA]):
                self._bullet.changeDynamics(self._body, joint, jointDamping=0.0)

    def set_positions(self, positions: Array) -> None:
        """Set the positions of the arm's joints; the fingers keep theirs."""
        for joint, position in zip(self._joints, positions.tolist(), strict=True):
            self._bullet.resetJointState(self._body, joint, position)

    def states(self) -> JointStates:
        """See `Engine.joint_states`."""
        states = self._bullet.getJointStates(self._body, self.all_joints)
        positions, velocities, _, efforts = zip(*states, strict=True)
        return JointStates(np.array(positions), np.array(velocities), np.array(efforts))

    def command_joints(self, positions: Array, velocities: Array) -> None:
        """See `Engine.command_joints`."""
        self._targets, self._rates = positions, velocities
        count = len(self._joints)
        self._bullet.setJointMotorControlArray(
            self._body,
            self._joints,
            pybullet.POSITION_CONTROL,
            targetPositions=positions.tolist(),
            targetVelocities=velocities.tolist(),
            forces=self._torques,
            positionGains=[POSITION_GAIN] * count,
            velocityGains=[VELOCITY_GAIN] * count,
        )

    @property
    def command(self) -> ArmCommand:
        """The last command."""
        return ArmCommand(self._targets, self._rates, self._grip)

    def apply_command(self, command: ArmCommand) -> None:
        """Set the motor targets from a command."""
        self.command_joints(command.targets, command.rates)
        if self._fingers:
            self.command_fingers(*command.fingers)

    @property
    def is_moving(self) -> bool:
        """Whether the joint targets move."""
        return bool(self._rates.any())

    def advance_targets(self, time: float) -> None:
        """Advance the joint targets by a duration [s]."""
        self.command_joints(self._targets + time * self._rates, self._rates)

    def command_fingers(self, position: float, force: float) -> None:
        """See `Engine.command_fingers`."""
        self._grip = (position, force)
        self._bullet.setJointMotorControlArray(
            self._body,
            self._fingers,
            pybullet.POSITION_CONTROL,
            targetPositions=[position, position],
            forces=[force, force],
            positionGains=[FINGER_GAIN, FINGER_GAIN],
        )

    def link_name(self, number: int) -> str:
        """Return the name of a link; empty for the base."""
        return "" if number == BASE else self._links[number]

    def contacts(self, owners: Mapping[int, str]) -> frozenset[tuple[str, str]]:
        """See `Engine.link_contacts`."""
        points = self._bullet.getContactPoints(bodyA=self._body)
        return frozenset(
            (self._links[point[LINK_A]], owners[point[BODY_B]])
            for point in points
            if is_touching(point) and point[BODY_B] != self._body and point[LINK_A] not in self._still
        )

    def overlaps(
        self,
        positions: Array,
        owners: Mapping[int, str],
        own: Sequence[tuple[str, str]],
        load: str,
        shapes: Sequence[Mapping[str, Any]],
    ) -> list[Overlap]:
        """Return the overlaps of the links at hypothetical joint positions.

        Args:
            positions: Positions of the arm's joints [rad].
            owners: Entities to check by body number.
            own: Pairs of links of the arm to check.
            load: Name of the carried body.
            shapes: Shapes of the carried body; see `PlacedShapes.of`.
        """
        states = self._bullet.getJointStates(self._body, self._joints)
        self.set_positions(positions)
        found = [overlap for number, name in owners.items() for overlap in self._in_body(number, name)]
        found += [overlap for pair in own for overlap in self._in_itself(*pair)]
        found += [overlap for shape in shapes for overlap in self._of_load(load, shape, owners)]
        # Saving and restoring the whole state would be as exact, but several times slower.
        for joint, (position, velocity, *_) in zip(self._joints, states, strict=True):
            self._bullet.resetJointState(self._body, joint, position, velocity)
        return found

    def _in_body(self, number: int, name: str) -> list[Overlap]:
        points = self._bullet.getClosestPoints(bodyA=self._body, bodyB=number, distance=0.0)
        return [
            Overlap(self._links[point[LINK_A]], name, -point[DISTANCE])
            for point in points
            if point[DISTANCE] < 0.0 and point[LINK_A] not in self._still
        ]

    def _in_itself(self, first: str, second: str) -> list[Overlap]:
        points = self._bullet.getClosestPoints(
            bodyA=self._body,
            bodyB=self._body,
            distance=0.0,
            linkIndexA=self._numbers[first],
            linkIndexB=self._numbers[second],
        )
        return [Overlap(first, second, -point[DISTANCE]) for point in points if point[DISTANCE] < 0.0]

    def _of_load(self, load: str, shape: Mapping[str, Any], owners: Mapping[int, str]) -> list[Overlap]:
        found = []
        for number in (*owners, self._body):
            for point in self._bullet.getClosestPoints(bodyA=-1, bodyB=number, distance=0.0, **shape):
                if point[DISTANCE] < 0.0:
                    other = owners[number] if number in owners else self._links[point[LINK_B]]
                    found.append(Overlap(load, other, -point[DISTANCE]))
        return found


def _still_links(bullet: Any, body: int) -> frozenset[int]:
    """Return the indices of the base, and of links that fixed joints hold on a base that never moves."""
    still = {BASE}
    if bullet.getDynamicsInfo(body, BASE)[MASS] == 0.0:
        for index in range(bullet.getNumJoints(body)):  # parents come before their children
            info = bullet.getJointInfo(body, index)
            if info[JOINT_TYPE] == bullet.JOINT_FIXED and info[PARENT] in still:
                still.add(index)
    return frozenset(still)


class PlacedShapes:
    """Collision shapes of bodies at hypothetical poses; each is made once.

    Moving the body itself and back would change the last bits of its pose.
    """

    def __init__(self, bullet: Any) -> None:
        self._bullet = bullet
        self._shapes: dict[Shape, int] = {}

    def of(self, model: BodyModel, state: BodyState) -> list[dict[str, Any]]:
        """Return arguments of `getClosestPoints` for the shapes of a body in a state."""
        turn = rotation_matrix(state.orientation)
        return [
            {
                "collisionShapeA": self._shape(part.shape),
                "collisionShapePositionA": (np.array(state.position) + turn @ part.position).tolist(),
                "collisionShapeOrientationA": xyzw(multiply(state.orientation, part.orientation)),
            }
            for part in model.parts
        ]

    def _shape(self, shape: Shape) -> int:
        if shape not in self._shapes:
            self._shapes[shape] = self._bullet.createCollisionShape(**_arguments(shape))
        return self._shapes[shape]


def _arguments(shape: Shape) -> dict[str, Any]:
    match shape:
        case Box(size=(x, y, z)):
            return {"shapeType": pybullet.GEOM_BOX, "halfExtents": [x / 2, y / 2, z / 2]}
        case Cylinder(radius=radius, length=length):
            return {"shapeType": pybullet.GEOM_CYLINDER, "radius": radius, "height": length}
        case Sphere(radius=radius):
            return {"shapeType": pybullet.GEOM_SPHERE, "radius": radius}
        case Capsule(radius=radius, length=length):
            return {"shapeType": pybullet.GEOM_CAPSULE, "radius": radius, "height": length}
        case Hull():
            return {"shapeType": pybullet.GEOM_MESH, "vertices": shape.points.tolist()}
        case _:
            assert_never(shape)

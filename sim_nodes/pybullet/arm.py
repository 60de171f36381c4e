"""Arms in PyBullet: motors that hold positions within their torque, and what links touch.

The links of an arm do not collide with each other, which is Bullet's default: paths are checked for that before
the arm moves.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, assert_never

import numpy as np

from sim_nodes.geometry import Array, multiply, rotation_matrix
from sim_nodes.physics import BodyModel, BodyState, Box, Cylinder, JointStates, Overlap, Shape, Sphere
from sim_nodes.pybullet.model import BASE, XYZW, Links, xyzw
from sim_nodes.pybullet.output import caught
from sim_nodes.robots.declaration import ArmDeclaration

with caught():  # it prints when it was built
    import pybullet

# Fields of what getContactPoints and getClosestPoints tell of a point.
BODY_A, BODY_B, LINK_A, LINK_B, DISTANCE, FORCE = 1, 2, 3, 4, 8, 9
MAX_FORCE = 10  # field of what getJointInfo tells: the effort of the URDF
POSITION_GAIN, VELOCITY_GAIN = 0.3, 1.0  # parts of an error that a motor makes up for in one step
FINGER_GAIN = 0.1
COUPLING_FORCE, COUPLING_ERROR_REDUCTION = 1000.0, 0.2  # of what keeps fingers at equal positions [N]


def is_touching(point: Sequence[Any]) -> bool:
    """Whether a contact point is one: points are kept from 2 cm on, before anything touches."""
    return bool(point[DISTANCE] <= 0.0 or point[FORCE] > 0.0)


@dataclass(frozen=True)
class ArmCommand:
    """What the motors of an arm were told last.

    Attributes:
        targets: Where they pull the joints to [rad].
        rates: How fast that moves [rad/s].
        fingers: Where the fingers are pulled to [m], and by which force at most [N].
    """

    targets: Array
    rates: Array
    fingers: tuple[float, float]


@dataclass(frozen=True)
class Ghost:
    """A part of a body that is somewhere in thought: name of the body, number of the shape, and its place."""

    name: str
    shape: int
    position: list[float]
    orientation: XYZW


class PybulletArm:
    """The joints and links of an arm.

    Args:
        bullet: Bullet.
        body: Number of the robot's body.
        links: Its links and joints.
        arm: What is declared of its arm.
    """

    def __init__(self, bullet: Any, body: int, links: Links, arm: ArmDeclaration) -> None:
        self._bullet, self._body = bullet, body
        self._links = {number: name for name, number in links.links.items()}
        self._numbers = links.links
        self._joints = [links.joints[joint.name] for joint in arm.joints]
        self._fingers = [links.joints[name] for name in arm.gripper.joints]
        self._torques = [bullet.getJointInfo(body, joint)[MAX_FORCE] for joint in self._joints]
        home = np.array([joint.home for joint in arm.joints])
        finger = arm.gripper.stroke / 2.0
        self.put(home)
        for joint in self._fingers:
            bullet.resetJointState(body, joint, finger)
        for name in arm.gripper.links:
            bullet.changeDynamics(
                body,
                links.links[name],
                lateralFriction=arm.gripper.friction,
                spinningFriction=arm.gripper.torsional_friction,
                # Without, friction is of speeds only: what is moved fast while it is held slips by millimetres.
                frictionAnchor=True,
            )
        self._couple_fingers()
        self.command_joints(home, np.zeros(len(home)))
        self.command_fingers(finger, arm.gripper.max_force)

    def _couple_fingers(self) -> None:
        """Keep the fingers at equal positions, as the gear of a gripper does; Bullet does not know `mimic`."""
        left, right = self._fingers
        gear = self._bullet.createConstraint(
            self._body, left, self._body, right, pybullet.JOINT_GEAR, [1, 0, 0], [0, 0, 0], [0, 0, 0]
        )
        self._bullet.changeConstraint(gear, gearRatio=-1, maxForce=COUPLING_FORCE, erp=COUPLING_ERROR_REDUCTION)

    def put(self, positions: Array) -> None:
        """Put the joints of the arm to positions at once, the fingers left as they are."""
        for joint, position in zip(self._joints, positions.tolist(), strict=True):
            self._bullet.resetJointState(self._body, joint, position)

    @property
    def all_joints(self) -> tuple[int, ...]:
        """Numbers of the joints of the arm and the fingers."""
        return (*self._joints, *self._fingers)

    def states(self) -> JointStates:
        """See `Engine.joint_states`."""
        states = self._bullet.getJointStates(self._body, self._joints + self._fingers)
        positions, velocities, _, efforts = zip(*states, strict=True)
        return JointStates(np.array(positions), np.array(velocities), np.array(efforts))

    def command_joints(self, positions: Array, velocities: Array) -> None:
        """See `Engine.command_joints`."""
        self._targets, self._rates = positions, velocities
        self._pull()

    @property
    def command(self) -> ArmCommand:
        """What the motors were told last."""
        return ArmCommand(self._targets, self._rates, self._grip)

    def take_up(self, command: ArmCommand) -> None:
        """Go on with a command."""
        self.command_joints(command.targets, command.rates)
        self.command_fingers(*command.fingers)

    @property
    def is_moving(self) -> bool:
        """Whether what the motors pull the joints to moves."""
        return bool(self._rates.any())

    def follow(self, time: float) -> None:
        """Move what the motors pull the joints to, by what it moves in a time [s]."""
        self._targets = self._targets + time * self._rates
        self._pull()

    def _pull(self) -> None:
        count = len(self._joints)
        self._bullet.setJointMotorControlArray(
            self._body,
            self._joints,
            pybullet.POSITION_CONTROL,
            targetPositions=self._targets.tolist(),
            targetVelocities=self._rates.tolist(),
            forces=self._torques,
            positionGains=[POSITION_GAIN] * count,
            velocityGains=[VELOCITY_GAIN] * count,
        )

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
        """The name of a link; empty for the base."""
        return "" if number == BASE else self._links[number]

    def contacts(self, owners: Mapping[int, str]) -> frozenset[tuple[str, str]]:
        """See `Engine.link_contacts`."""
        points = self._bullet.getContactPoints(bodyA=self._body)
        return frozenset(
            (self._links[point[LINK_A]], owners[point[BODY_B]])
            for point in points
            if is_touching(point) and point[BODY_B] != self._body and point[LINK_A] != BASE
        )

    def overlaps(
        self,
        positions: Array,
        owners: Mapping[int, str],
        own: Sequence[tuple[str, str]],
        carried: Sequence[Ghost],
    ) -> list[Overlap]:
        """What the links would be inside of with the joints at positions.

        Args:
            positions: Of the arm's joints [rad].
            owners: Names of what is looked at besides the arm, by the numbers of the bodies.
            own: Pairs of links of the arm that are looked at.
            carried: The parts of what it carries.
        """
        states = self._bullet.getJointStates(self._body, self._joints)
        self.put(positions)
        found = [overlap for number, name in owners.items() for overlap in self._in_body(number, name)]
        found += [overlap for pair in own for overlap in self._in_itself(*pair)]
        found += [overlap for ghost in carried for overlap in self._of_ghost(ghost, owners)]
        # Saving and restoring the whole state would be as exact, and takes several times as long as all of this.
        for joint, (position, velocity, *_) in zip(self._joints, states, strict=True):
            self._bullet.resetJointState(self._body, joint, position, velocity)
        return found

    def _in_body(self, number: int, name: str) -> list[Overlap]:
        points = self._bullet.getClosestPoints(bodyA=self._body, bodyB=number, distance=0.0)
        return [
            Overlap(self._links[point[LINK_A]], name, -point[DISTANCE])
            for point in points
            if point[DISTANCE] < 0.0 and point[LINK_A] != BASE
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

    def _of_ghost(self, ghost: Ghost, owners: Mapping[int, str]) -> list[Overlap]:
        found = []
        for number in (*owners, self._body):
            points = self._bullet.getClosestPoints(
                bodyA=-1,
                bodyB=number,
                distance=0.0,
                collisionShapeA=ghost.shape,
                collisionShapePositionA=ghost.position,
                collisionShapeOrientationA=ghost.orientation,
            )
            for point in points:
                if point[DISTANCE] < 0.0:
                    other = owners[number] if number in owners else self._links[point[LINK_B]]
                    found.append(Overlap(ghost.name, other, -point[DISTANCE]))
        return found


class Ghosts:
    """Shapes of bodies that are somewhere in thought only; each is made once.

    To move the body itself and put it back would change the last bits of where it is.
    """

    def __init__(self, bullet: Any) -> None:
        self._bullet = bullet
        self._shapes: dict[Shape, int] = {}

    def of(self, name: str, model: BodyModel, state: BodyState) -> list[Ghost]:
        """The parts of a body in a state."""
        turn = rotation_matrix(state.orientation)
        return [
            Ghost(
                name,
                self._shape(part.shape),
                (np.array(state.position) + turn @ part.position).tolist(),
                xyzw(multiply(state.orientation, part.orientation)),
            )
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
        case _:
            assert_never(shape)

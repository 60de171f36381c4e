"""Steps of Bullet, which miss no begin or end of a contact.

Requesting contacts after each step costs a third of the step. It is skipped after the
distances of all bodies were measured, as long as no body has moved far or can do so by its speed. Contacts with
the floor do not count.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from typing import Any, NamedTuple, Protocol

import pybullet

from seoro.deferred import dataclass
from sim_nodes.physics import FLOOR, UnstablePhysics, entity_pairs
from sim_nodes.pybullet.joints import BODY_A, BODY_B, DISTANCE, FORCE, LINK_A, LINK_B, PybulletArm
from sim_nodes.pybullet.model import BASE, XYZW

Vector = tuple[float, float, float]

REACH = 1.0  # [m] maximum measured distance
ACCELERATION = 30.0  # [m/s^2]; exceeds gravity, wheels, and arms that hold their position
MANY = 40  # moving bodies; with more, distances are not measured
RETRY = 40  # steps after distances that were too small


class Pose(NamedTuple):
    """Pose of a body's centre of mass, and positions and velocities of its joints except wheels."""

    place: Vector
    turn: XYZW
    joints: tuple[float, ...]
    rates: tuple[float, ...]  # of these joints


class StepForces(Protocol):
    """Forces for one step."""

    def apply(self) -> None:
        """Apply the forces of one step."""


class StepSum(Protocol):
    """Sums something over steps."""

    def add_step(self) -> None:
        """Add the step that was made."""


@dataclass(frozen=True)
class Clearance:
    """Poses of bodies when their distances were measured, and how far each may move from there [m]."""

    poses: tuple[Pose, ...]
    room: float


class Stepper:
    """Steps a world.

    Args:
        client: Number of the connection.
        timestep: Length of a step [s].
        owners: Entity of each body; updated by the owner.
        static: Bodies with a static base; updated by the owner.
        jointed: Bodies with movable joints, and these joints.
        forces: Forces to apply before each step.
        sums: Sums to add each step to; updated by the owner.

    Attributes:
        touching: Pairs in contact in the last step.
        has_diverged: Whether the physics has diverged.
    """

    def __init__(
        self,
        client: int,
        timestep: float,
        owners: Mapping[int, str],
        static: Set[int],
        jointed: Mapping[int, tuple[int, ...]],
        forces: Sequence[StepForces] = (),
        sums: Sequence[StepSum] = (),
    ) -> None:
        self._client = client
        self._timestep = timestep
        self._owners, self._static, self._jointed = owners, static, jointed
        self._forces, self._sums = forces, sums
        self.touching: frozenset[tuple[str, str]] = frozenset()
        self.has_diverged = False
        self.invalidate()

    def invalidate(self, wait: int = 0) -> None:
        """Discard measured distances after bodies were moved, added or removed; measure none for `wait` steps."""
        self._clearance: Clearance | None = None
        self._wait = wait
        still = set(self._static) - self._jointed.keys()
        self._still = [body for body in still if self._owners[body] != FLOOR]
        self._moving = [body for body in self._owners if body not in still]
        self._clear = 0  # steps from the last measurement in which nothing can touch
        self._radii: list[float] = []
        self._bodies: set[tuple[int, int]] = set()  # body numbers that touched in the last step
        self._of_bodies: frozenset[tuple[str, str]] = frozenset()  # entities of `_bodies`

    def step(self, count: int, arms: Sequence[PybulletArm]) -> int:
        """Make up to `count` steps, to the first in which the pairs in contact change; returns their number.

        Args:
            count: Maximum number of steps.
            arms: Arms with moving targets, which are advanced after each step.

        Raises:
            UnstablePhysics: Bullet found no positions.
        """
        made, changed = 0, False
        while made < count and not changed:
            some = 0 if arms else min(count - made, self._clear_steps())
            if some:
                for _ in range(some):
                    self._make_step()
            else:
                some, changed = self._step_checking_contacts(min(count - made, RETRY), arms)
            made += some
            self._track(self._poses())
        return made

    def _make_step(self) -> None:
        for each in self._forces:
            each.apply()
        pybullet.stepSimulation(self._client)
        for total in self._sums:
            total.add_step()

    def repeat(self, count: int, arms: Sequence[PybulletArm]) -> int:
        """Repeat `count` steps with the same contacts as before, without looking for them."""
        for _ in range(count):
            self._make_step()
            for arm in arms:
                arm.advance_targets(self._timestep)
        self.touching = self._pairs()
        return count

    def _step_checking_contacts(self, count: int, arms: Sequence[PybulletArm]) -> tuple[int, bool]:
        """Make steps until the pairs in contact change; returns their number, and whether they changed."""
        self._wait -= count
        for made in range(1, count + 1):
            self._make_step()
            for arm in arms:
                arm.advance_targets(self._timestep)
            touching = self._pairs()
            if touching != self.touching:
                self.touching = touching
                return made, True
        return count, False

    def _pairs(self) -> frozenset[tuple[str, str]]:
        # Bodies touch at several points, mostly the same in each step.
        touching = {
            (point[BODY_A], point[BODY_B])
            for point in pybullet.getContactPoints(physicsClientId=self._client)
            if (point[DISTANCE] <= 0.0 or point[FORCE] > 0.0) and not self._is_static_contact(point)
        }
        if touching != self._bodies:
            self._bodies, self._of_bodies = touching, entity_pairs(touching, self._owners)
        return self._of_bodies

    def _is_static_contact(self, point: Sequence[Any]) -> bool:
        """Whether neither body of a contact can move, such as an arm's base and its pedestal."""
        return (
            point[BODY_A] in self._static
            and point[BODY_B] in self._static
            and point[LINK_A] == BASE
            and point[LINK_B] == BASE
        )

    # ------------------------------------------------------------ steps without contacts

    def _poses(self) -> tuple[Pose, ...]:
        poses = tuple(map(self._pose, self._moving))
        if not math.isfinite(sum(sum(pose.place) + sum(pose.joints) for pose in poses)):
            self.has_diverged = True
            raise UnstablePhysics("Bullet found no positions: reset the simulation")
        return poses

    def _pose(self, body: int) -> Pose:
        place, turn = pybullet.getBasePositionAndOrientation(body, self._client)
        joints = self._jointed.get(body)
        if joints is None:
            return Pose(place, turn, (), ())
        states = pybullet.getJointStates(body, joints, self._client)
        return Pose(place, turn, tuple(state[0] for state in states), tuple(state[1] for state in states))

    def _track(self, poses: tuple[Pose, ...]) -> None:
        """Track the motion of bodies, and compute how many steps are safe."""
        if self._clearance is not None:
            moved = max(map(_moved, self._radii, self._clearance.poses, poses), default=0.0)
            self._clear = self._steps_within(self._clearance.room - moved, poses)
            if not self._clear:
                self._clearance, self._wait = None, 0

    def _clear_steps(self) -> int:
        """Return the number of steps in which nothing can touch."""
        if self._clearance is None and self._wait <= 0 and not self.touching and len(self._moving) <= MANY:
            self._wait = RETRY
            self._measure()
        return 0 if self._clearance is None else self._clear

    def _measure(self) -> None:
        """Measure distances, and keep them if they are large enough."""
        if not self._radii:
            self._radii = [self._radius(body) for body in self._moving]
        poses = self._poses()
        room = self._room(poses)
        self._clear = self._steps_within(room, poses)
        if self._clear:
            self._clearance = Clearance(poses, room)

    def _steps_within(self, room: float, poses: tuple[Pose, ...]) -> int:
        """Return the number of steps in which no point of a body can move further than `room` [m]."""
        speed = max(map(self._speed, self._radii, self._moving, poses), default=0.0)
        if not (room > 0.0 and speed < math.inf):
            return 0
        # Solves room = speed * time + ACCELERATION / 2 * time**2 without a difference of large numbers.
        time = 2.0 * room / (speed + math.hypot(speed, math.sqrt(2.0 * ACCELERATION * room)))
        return int(time / self._timestep)

    def _radius(self, body: int) -> float:
        """Return the radius of a sphere around a body's centre of mass that contains it in any posture [m]."""
        count = pybullet.getNumJoints(body, self._client)
        boxes = [pybullet.getAABB(body, link, self._client) for link in range(BASE, count)]
        if body in self._jointed:
            return sum(math.dist(low, high) for low, high in boxes)
        centre, _ = pybullet.getBasePositionAndOrientation(body, self._client)
        return math.hypot(
            *(max(abs(corner[axis] - centre[axis]) for box in boxes for corner in box) for axis in range(3))
        )

    def _speed(self, radius: float, body: int, pose: Pose) -> float:
        """Return the maximum speed of a point of a body within a radius of its centre [m/s]."""
        linear, angular = pybullet.getBaseVelocity(body, self._client)
        return math.hypot(*linear) + radius * (math.hypot(*angular) + sum(map(abs, pose.rates)))

    def _room(self, poses: tuple[Pose, ...]) -> float:
        """Return how far each body may move before two can touch, at most `REACH` [m]."""
        room = REACH
        for index, body in enumerate(self._moving):
            for other in self._still:
                room = self._nearest(body, other, room)
            for other in range(index):
                apart = math.dist(poses[index].place, poses[other].place) - self._radii[index] - self._radii[other]
                if apart < 2.0 * room:  # both may move
                    room = self._nearest(body, self._moving[other], 2.0 * room) / 2.0
        return room

    def _nearest(self, body: int, other: int, least: float) -> float:
        """Return the smaller of the distance of two bodies and `least` [m]."""
        points = pybullet.getClosestPoints(body, other, least, physicsClientId=self._client)
        distances: list[float] = [point[DISTANCE] for point in points if not self._is_static_contact(point)]
        return min(distances, default=least)


def _moved(radius: float, then: Pose, now: Pose) -> float:
    """Return the maximum displacement of a point of a body within a radius of its centre [m]."""
    # Rotation moves a point by twice the radius times the sine of half the angle; this is an upper bound.
    turned = min(math.dist(then.turn, now.turn), math.dist(then.turn, [-part for part in now.turn]))
    bent = sum(abs(b - a) for a, b in zip(then.joints, now.joints, strict=True))
    return math.dist(then.place, now.place) + radius * (2.0 * turned + bent)

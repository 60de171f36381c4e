"""Steps of Bullet, and none in which a contact begins or ends unseen.

Asking for contacts after each step costs a third of the step itself. So it is left out where nothing can touch:
when the distances of all bodies have been measured, and no body has moved far since, or can for a while by how
fast it is. That bodies touch the floor does not count.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence, Set
from dataclasses import dataclass
from typing import Any, NamedTuple

import pybullet

from sim_nodes.physics import FLOOR, UnstablePhysics
from sim_nodes.pybullet.arm import BODY_A, BODY_B, DISTANCE, FORCE, LINK_A, LINK_B, PybulletArm
from sim_nodes.pybullet.model import BASE, XYZW

Vector = tuple[float, float, float]

REACH = 1.0  # [m] to which distances are measured
ACCELERATION = 30.0  # [m/s^2]; more than weight or wheels give, and motors of arms once these hold still
MANY = 40  # bodies that move; between more, no distances are measured
RETRY = 40  # steps until distances are measured again, after they were too small


class Pose(NamedTuple):
    """Where a body is: its centre of mass, and its joints but for wheels; with how fast these turn."""

    place: Vector
    turn: XYZW
    joints: tuple[float, ...]
    rates: tuple[float, ...]  # of these joints


@dataclass(frozen=True)
class Survey:
    """Where bodies were when their distances were measured, and how far each may move from there [m]."""

    poses: tuple[Pose, ...]
    room: float


class Stepper:
    """Makes the steps of a world.

    Args:
        client: Number of the connection.
        timestep: Length of a step [s].
        owners: The entity of each body, which is kept up to date by the owner.
        static: The bodies that have a base which does not move, likewise.
        jointed: Those that have joints which move them, and the joints.

    Attributes:
        touching: The pairs in contact in the last step.
        is_lost: Whether the physics were lost in a step.
    """

    def __init__(
        self,
        client: int,
        timestep: float,
        owners: Mapping[int, str],
        static: Set[int],
        jointed: Mapping[int, tuple[int, ...]],
    ) -> None:
        self._client = client
        self._timestep = timestep
        self._owners, self._static, self._jointed = owners, static, jointed
        self.touching: frozenset[tuple[str, str]] = frozenset()
        self.is_lost = False
        self.disturb()

    def disturb(self, wait: int = 0) -> None:
        """Take note that bodies were moved, have come or gone; no distance is measured for `wait` steps."""
        self._survey: Survey | None = None
        self._wait = wait
        still = set(self._static) - self._jointed.keys()
        self._still = [body for body in still if self._owners[body] != FLOOR]
        self._moving = [body for body in self._owners if body not in still]
        self._clear = 0  # steps from the last look in which nothing can touch, with a survey
        self._radii: list[float] = []
        self._bodies: set[tuple[int, int]] = set()  # that touched in the last step, by their numbers
        self._of_bodies: frozenset[tuple[str, str]] = frozenset()  # the entities of these

    def make(self, count: int, arms: Sequence[PybulletArm]) -> int:
        """Make up to `count` steps; returns how many, fewer if the pairs in contact have changed in the last.

        Args:
            count: How many.
            arms: Those that move, which have to be led on after each step.

        Raises:
            UnstablePhysics: Bullet found no positions.
        """
        made, changed = 0, False
        while made < count and not changed:
            some = 0 if arms else min(count - made, self._clear_steps())
            if some:
                for _ in range(some):
                    pybullet.stepSimulation(self._client)
            else:
                some, changed = self._watchfully(min(count - made, RETRY), arms)
            made += some
            self._follow(self._poses())
        return made

    def repeat(self, count: int, arms: Sequence[PybulletArm]) -> int:
        """Make `count` steps that were made before, with the same contacts, so that none has to be looked for."""
        for _ in range(count):
            pybullet.stepSimulation(self._client)
            for arm in arms:
                arm.follow(self._timestep)
        self.touching = self._pairs()
        return count

    def _watchfully(self, count: int, arms: Sequence[PybulletArm]) -> tuple[int, bool]:
        """Make steps until the pairs in contact change; returns how many, and whether they did."""
        self._wait -= count
        for made in range(1, count + 1):
            pybullet.stepSimulation(self._client)
            for arm in arms:
                arm.follow(self._timestep)
            touching = self._pairs()
            if touching != self.touching:
                self.touching = touching
                return made, True
        return count, False

    def _pairs(self) -> frozenset[tuple[str, str]]:
        # Bodies touch at several points, and most of these are the same in most steps.
        touching = {
            (point[BODY_A], point[BODY_B])
            for point in pybullet.getContactPoints(physicsClientId=self._client)
            if (point[DISTANCE] <= 0.0 or point[FORCE] > 0.0) and not self._stand(point)
        }
        if touching != self._bodies:
            self._bodies, pairs = touching, set()
            for first, second in touching:
                a, b = self._owners[first], self._owners[second]
                if a != b and FLOOR not in (a, b):
                    pairs.add((min(a, b), max(a, b)))
            self._of_bodies = frozenset(pairs)
        return self._of_bodies

    def _stand(self, point: Sequence[Any]) -> bool:
        """Whether neither of the two that touch can move, such as an arm's base and what it stands on."""
        return (
            point[BODY_A] in self._static
            and point[BODY_B] in self._static
            and point[LINK_A] == BASE
            and point[LINK_B] == BASE
        )

    # ------------------------------------------------------------ where nothing can touch

    def _poses(self) -> tuple[Pose, ...]:
        poses = tuple(map(self._pose, self._moving))
        if not math.isfinite(sum(sum(pose.place) + sum(pose.joints) for pose in poses)):
            self.is_lost = True
            raise UnstablePhysics("Bullet found no positions: reset the simulation")
        return poses

    def _pose(self, body: int) -> Pose:
        place, turn = pybullet.getBasePositionAndOrientation(body, self._client)
        joints = self._jointed.get(body)
        if joints is None:
            return Pose(place, turn, (), ())
        states = pybullet.getJointStates(body, joints, self._client)
        return Pose(place, turn, tuple(state[0] for state in states), tuple(state[1] for state in states))

    def _follow(self, poses: tuple[Pose, ...]) -> None:
        """Take note of how far bodies have moved, and find how many steps none of them can go too far in."""
        if self._survey is not None:
            moved = max(map(_moved, self._radii, self._survey.poses, poses), default=0.0)
            self._clear = self._steps_within(self._survey.room - moved, poses)
            if not self._clear:
                self._survey, self._wait = None, 0

    def _clear_steps(self) -> int:
        """The number of steps in which nothing can touch."""
        if self._survey is None and self._wait <= 0 and not self.touching and len(self._moving) <= MANY:
            self._wait = RETRY
            self._measure()
        return 0 if self._survey is None else self._clear

    def _measure(self) -> None:
        """Measure distances, and keep them if they are any use."""
        if not self._radii:
            self._radii = [self._radius(body) for body in self._moving]
        poses = self._poses()
        room = self._room(poses)
        self._clear = self._steps_within(room, poses)
        if self._clear:
            self._survey = Survey(poses, room)

    def _steps_within(self, room: float, poses: tuple[Pose, ...]) -> int:
        """The number of steps in which no point of a body can move further than that [m]."""
        speed = max(map(self._speed, self._radii, self._moving, poses), default=0.0)
        if not (room > 0.0 and speed < math.inf):
            return 0
        # Of room = speed * time + ACCELERATION / 2 * time**2, without a difference of what may be large.
        time = 2.0 * room / (speed + math.hypot(speed, math.sqrt(2.0 * ACCELERATION * room)))
        return int(time / self._timestep)

    def _radius(self, body: int) -> float:
        """Of a sphere about a body's centre of mass that holds it [m], whatever way it and its joints turn."""
        count = pybullet.getNumJoints(body, self._client)
        boxes = [pybullet.getAABB(body, link, self._client) for link in range(BASE, count)]
        if body in self._jointed:
            return sum(math.dist(low, high) for low, high in boxes)
        centre, _ = pybullet.getBasePositionAndOrientation(body, self._client)
        return math.hypot(
            *(max(abs(corner[axis] - centre[axis]) for box in boxes for corner in box) for axis in range(3))
        )

    def _speed(self, radius: float, body: int, pose: Pose) -> float:
        """How fast a point of a body, within a radius of its centre and its joints, may be [m/s]."""
        linear, angular = pybullet.getBaseVelocity(body, self._client)
        return math.hypot(*linear) + radius * (math.hypot(*angular) + sum(map(abs, pose.rates)))

    def _room(self, poses: tuple[Pose, ...]) -> float:
        """How far each body may move before two can touch, or `REACH` [m]."""
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
        """The distance of two bodies, or, if that is less, `least` [m]."""
        points = pybullet.getClosestPoints(body, other, least, physicsClientId=self._client)
        distances: list[float] = [point[DISTANCE] for point in points if not self._stand(point)]
        return min(distances, default=least)


def _moved(radius: float, then: Pose, now: Pose) -> float:
    """How far a point of a body, within a radius of its centre and its joints, has moved at most [m]."""
    # By turning, a point moves by twice the radius times the sine of half the angle, which this is not less than.
    turned = min(math.dist(then.turn, now.turn), math.dist(then.turn, [-part for part in now.turn]))
    bent = sum(abs(b - a) for a, b in zip(then.joints, now.joints, strict=True))
    return math.dist(then.place, now.place) + radius * (2.0 * turned + bent)

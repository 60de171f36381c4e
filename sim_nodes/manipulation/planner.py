"""Planning of arm paths, checked for limits and collisions before the arm moves.

A colliding path is refused; detours are not planned. Present overlaps, as after gripping from a table, are
ignored as long as the arm does not go deeper.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np

from seoro.bridges.wire import ArmResult
from seoro.bridges.wire.refusal import RequestRefused
from seoro.deferred import dataclass
from sim_nodes.geometry import Array, quaternion_of, rotation_matrix, vector
from sim_nodes.manipulation.chain import (
    Chain,
    Limits,
    colliding_pairs,
    gripper_links,
    inverse,
    joint_limits,
    pose_matrix,
)
from sim_nodes.manipulation.inverse_kinematics import (
    MORE_STARTS,
    NEAREST,
    STARTS,
    out_of_reach,
    pose_error,
    rotation_vector,
    solutions,
    solve,
)
from sim_nodes.manipulation.motion import Path
from sim_nodes.manipulation.moved_links import base_in_map
from sim_nodes.noise import Noise
from sim_nodes.outcomes import operation_failed
from sim_nodes.physics import MAX_OVERLAP, BodyState, CarriedBody, Engine, Overlap, PlacedRobot
from sim_nodes.robots.declaration import ArmDeclaration

CHECK_STEP = 0.01  # [rad], [m] of a joint between two collision checks
OWN_CHECKS = 5  # collision checks per self-collision check, which takes longer
LINE_STEP, LINE_TURN = 0.01, 0.05  # [m], [rad] between two poses of a straight line
FLIP = 0.3  # [rad], [m]; a joint that moves more within one step of a line flips the arm
CARRIED_OVERLAP = 4e-3  # [m] overlap allowed for a carried body, such as with the table it is put on
DEEPER = 1e-3  # [m] by which present overlaps may grow
CANDIDATES = 8  # inverse kinematics solutions that are tried


@dataclass(frozen=True)
class AttachedObject:
    """A carried entity: its name and its pose in the tool, shape (4, 4)."""

    name: str
    pose_in_tool: Array


@dataclass(frozen=True)
class PlanningScene:
    """Start and surroundings of a path.

    `start` is the configuration of the arm, `load` the carried entity; `may_touch` are entities that
    the arm may collide with.
    """

    start: Array
    load: AttachedObject | None = None
    may_touch: frozenset[str] = frozenset()


class JointPlanner:
    """Plans paths of joints within their limits.

    Args:
        robot: Name of the robot.
        joints: Names of the joints.
        limits: Limits of the joints.
    """

    def __init__(self, robot: str, joints: tuple[str, ...], limits: Limits) -> None:
        self._robot, self.joints, self.limits = robot, joints, limits

    def through(self, now: PlanningScene, configurations: Sequence[Array]) -> Path:
        """Return the path through configurations.

        Raises:
            RequestRefused: A configuration is out of limits.
        """
        for configuration in configurations:
            self._check_limits(configuration)
        way = [now.start]
        for configuration in configurations:
            if np.abs(configuration - way[-1]).max() > 0.0:
                way.append(configuration)
        return Path(way if len(way) > 1 else [now.start, now.start])

    def _check_limits(self, configuration: Array) -> None:
        for name, position, lower, upper, unit in zip(
            self.joints, configuration, self.limits.lower, self.limits.upper, self.limits.units, strict=True
        ):
            if not lower <= position <= upper:
                raise RequestRefused(
                    ArmResult.OUT_OF_LIMITS,
                    f"invalid position {position:.3f} {unit} of {name} of {self._robot}; "
                    f"expected {lower:.3f} to {upper:.3f} {unit}",
                )


class Planner(JointPlanner):
    """Plans paths for one arm.

    Args:
        placed: Robot that has the arm.
        arm: Declaration of the arm, with a tool.
        engine: Engine that checks collisions.
    """

    def __init__(self, placed: PlacedRobot, arm: ArmDeclaration, engine: Engine) -> None:
        urdf, names = placed.declaration.urdf, [joint.name for joint in arm.joints]
        assert arm.tool_link is not None
        self.chain = Chain(urdf, placed.declaration.base_link, arm.tool_link, names)
        super().__init__(placed.name, self.chain.joints, self.chain.limits)
        self._engine = engine
        self._own, self._hand = colliding_pairs(urdf), gripper_links(urdf, arm.finger_links)
        self._home = np.array([joint.home for joint in arm.joints])
        self._noise = Noise(0, f"{placed.name}/inverse kinematics")  # independent of the seed, so that plans are
        self._fixed = base_in_map(engine, placed.name) if placed.declaration.fixed else None

    @property
    def pose_base_in_map(self) -> Array:
        """Pose of the base in `map`, shape (4, 4)."""
        return base_in_map(self._engine, self._robot) if self._fixed is None else self._fixed

    def through(self, now: PlanningScene, configurations: Sequence[Array]) -> Path:
        """Return the path through configurations.

        Raises:
            RequestRefused: A configuration is out of limits, or the path collides.
        """
        path = super().through(now, configurations)
        self._check_collisions(path, now)
        return path

    def to_pose(self, now: PlanningScene, target: Array) -> Path:
        """Return a path to a pose of the tool in `map`, shape (4, 4), straight in joint space.

        Raises:
            RequestRefused: The pose is out of reach, or all candidate paths collide.
        """
        aim = inverse(self.pose_base_in_map) @ target
        refused: RequestRefused | None = None
        found = solutions(self.chain, aim, now.start, self._home, self._noise)
        for _, configuration in zip(range(CANDIDATES), found, strict=False):
            try:
                return self.through(now, [configuration])
            except RequestRefused as error:
                refused = refused or error
        raise refused or RequestRefused(ArmResult.UNREACHABLE, self._describe_unreachable(target, aim))

    def _describe_unreachable(self, target: Array, aim: Array) -> str:
        """Return a text for an unreachable pose: proved to be out of reach, or no solution found."""
        beyond = out_of_reach(self.chain, aim)
        if beyond > 0.0:
            return (
                f"the tool of {self._robot} cannot reach {_place(target)}: {beyond:.3f} m beyond the "
                f"stretched arm of {self.chain.reach:.3f} m"
            )
        return (
            f"the tool of {self._robot} cannot reach {_place(target)} in this orientation: no solution was found "
            f"from {STARTS + MORE_STARTS + NEAREST + 2} starts"
        )

    def straight(self, now: PlanningScene, target: Array) -> Path:
        """Return the path on which the tool moves straight to a pose in `map`, shape (4, 4).

        Raises:
            RequestRefused: The tool cannot follow the line, or the arm would collide.
        """
        start = self.chain.tool_pose(now.start)
        aim = inverse(self.pose_base_in_map) @ target
        length, angle = pose_error(start, aim)
        steps = max(1, math.ceil(length / LINE_STEP), math.ceil(angle / LINE_TURN))
        turn = rotation_vector(aim[:3, :3] @ start[:3, :3].T)
        way = [now.start]
        for step in range(1, steps + 1):
            share = step / steps
            between = start[:3, 3] + share * (aim[:3, 3] - start[:3, 3])
            pose = pose_matrix(between, _rotation(share * turn) @ start[:3, :3])
            found = solve(self.chain, pose, way[-1])
            if found is None or np.abs(found - way[-1]).max() > FLIP:
                raise RequestRefused(
                    ArmResult.UNREACHABLE,
                    f"the tool of {self._robot} cannot follow the straight line to {_place(target)} beyond "
                    f"{length * (step - 1) / steps:.2f} m of {length:.2f} m: it is out of reach, "
                    "or the arm would flip",
                )
            way.append(found)
        return self.through(now, way[1:])

    # ------------------------------------------------------------ checks

    def _check_collisions(self, path: Path, now: PlanningScene) -> None:
        present = self._overlaps(now.start, now, self._own)
        allowed = {(it.link, it.other): it.depth + DEEPER for it in present}
        for index, place in enumerate(self._places(path)):
            own = self._own if index % OWN_CHECKS == 0 else ()
            for overlap in self._overlaps(path.at(place), now, own):
                if overlap.other in now.may_touch:
                    continue
                is_load = now.load is not None and overlap.link == now.load.name
                limit = CARRIED_OVERLAP if is_load else MAX_OVERLAP
                if overlap.depth > max(limit, allowed.get((overlap.link, overlap.other), 0.0)):
                    what = f"{overlap.link!r}, which it holds," if is_load else overlap.link
                    raise RequestRefused(
                        ArmResult.IN_COLLISION,
                        f"{self._robot} would collide {_along(place)}: {what} with {overlap.other!r}",
                    )

    def _places(self, path: Path) -> list[float]:
        """Return the positions of collision checks on a path; the end first, which collides most often."""
        ways = np.abs(np.diff([path.at(knot) for knot in path.knots.tolist()], axis=0)).max(axis=1)
        count = max(1, math.ceil(float(ways.sum()) / CHECK_STEP))
        places: list[float] = np.linspace(0.0, 1.0, count + 1)[1:].tolist()
        return [places[-1], *places[:-1]]

    def _overlaps(
        self, configuration: Array, now: PlanningScene, own: tuple[tuple[str, str], ...]
    ) -> tuple[Overlap, ...]:
        found = self._engine.arm_overlaps(self._robot, configuration, own, self._carried(configuration, now))
        return tuple(it for it in found if not self._is_grip(it, now))

    def _carried(self, configuration: Array, now: PlanningScene) -> CarriedBody | None:
        if now.load is None:
            return None
        pose = self.pose_base_in_map @ self.chain.tool_pose(configuration) @ now.load.pose_in_tool
        return CarriedBody(now.load.name, BodyState(vector(pose[:3, 3]), quaternion_of(pose[:3, :3])))

    def _is_grip(self, overlap: Overlap, now: PlanningScene) -> bool:
        """Whether it is an overlap of the gripper with the held entity."""
        return now.load is not None and overlap.link == now.load.name and overlap.other in self._hand


def make_planner(placed: PlacedRobot, arm: ArmDeclaration, engine: Engine) -> JointPlanner:
    """Return the planner of position-controlled joints; see `Planner` for its arguments."""
    if arm.tool_link is not None:
        return Planner(placed, arm, engine)
    joints = tuple(joint.name for joint in arm.joints)
    return JointPlanner(placed.name, joints, joint_limits(placed.declaration.urdf, joints))


def check_count(robot: str, names: Sequence[str], positions: Sequence[float]) -> None:
    """Refuse positions that are not one finite number for each joint."""
    if len(positions) != len(names) or not all(map(math.isfinite, positions)):
        raise operation_failed(
            f"invalid positions {list(positions)} for {robot}; "
            f"expected a finite number for each of {', '.join(names)}"
        )


def _rotation(vector: Array) -> Array:
    """Return the (3, 3) matrix of a rotation vector [rad]."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = (math.sin(angle / 2) * vector / angle).tolist()
    return rotation_matrix((math.cos(angle / 2), x, y, z))


def _along(place: float) -> str:
    return "at its goal" if place == 1.0 else f"after {place:.0%} of its path"


def _place(pose: Array) -> str:
    x, y, z = pose[:3, 3]
    return f"({x:.3f}, {y:.3f}, {z:.3f})"

"""Paths for an arm that are checked before it moves: within limits, and free of collisions.

A path that would collide is refused, not led around what is in the way. What is in the way now, as after something
was gripped from a table, does not count as long as the arm does not go deeper into it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from seoro.bridges.wire import ArmResult, Result
from seoro.bridges.wire.refusal import RequestRefused
from sim_nodes.geometry import Array, quaternion_of, rotation_matrix
from sim_nodes.manipulation.chain import Chain, inverse, pose_matrix
from sim_nodes.manipulation.inverse_kinematics import (
    MORE_STARTS,
    STARTS,
    out_of_reach,
    pose_error,
    rotation_vector,
    solutions,
    solve,
)
from sim_nodes.manipulation.links import colliding_pairs, hand
from sim_nodes.manipulation.trajectory import Path
from sim_nodes.noise import Noise
from sim_nodes.physics import OVERLAP, BodyState, Carried, Engine, Overlap, PlacedRobot
from sim_nodes.robots.declaration import ArmDeclaration

CHECK_STEP = 0.01  # [rad] that a joint moves between two configurations that are checked for collisions
OWN_CHECKS = 5  # to every how many of them collisions of the arm with itself are looked for, which take longer
LINE_STEP, LINE_TURN = 0.01, 0.05  # [m], [rad] between two poses of a straight line
FLIP = 0.3  # [rad]; a joint that moves more than this within one step of a line turns the arm over
CARRIED_OVERLAP = 4e-3  # [m] that what is carried may go into something, such as what it is put on
DEEPER = 1e-3  # [m] that the arm may go deeper into what it is in already
CANDIDATES = 8  # solutions of the inverse kinematics that are tried


@dataclass(frozen=True)
class Load:
    """What an arm carries: name of the entity, and its pose in the tool, shape (4, 4)."""

    name: str
    pose_in_tool: Array


@dataclass(frozen=True)
class Circumstances:
    """What a path begins with.

    `start` is the configuration of the arm [rad]; `may_touch` are entities that it may collide with.
    """

    start: Array
    load: Load | None = None
    may_touch: frozenset[str] = frozenset()


class Planner:
    """Finds paths for one arm.

    Args:
        placed: The robot that has it.
        arm: What is declared of it.
        engine: The engine that it is in.
    """

    def __init__(self, placed: PlacedRobot, arm: ArmDeclaration, engine: Engine) -> None:
        self._robot, self._engine = placed.name, engine
        urdf, names = placed.declaration.urdf, [joint.name for joint in arm.joints]
        self.chain = Chain(urdf, placed.declaration.base_link, arm.tool_link, names)
        self._own, self._hand = colliding_pairs(urdf), hand(urdf, arm.gripper.links)
        self._home = np.array([joint.home for joint in arm.joints])
        self._noise = Noise(0, f"{placed.name}/inverse kinematics")  # whatever the seed: what is found decides
        self.pose_base_in_map = pose_matrix(placed.state.position, rotation_matrix(placed.state.orientation))

    def through(self, now: Circumstances, configurations: Sequence[Array]) -> Path:
        """The path through configurations.

        Raises:
            RequestRefused: One is out of the limits, or the arm would collide on the way.
        """
        for configuration in configurations:
            self._check_limits(configuration)
        way = [now.start]
        for configuration in configurations:
            if np.abs(configuration - way[-1]).max() > 0.0:
                way.append(configuration)
        path = Path(way if len(way) > 1 else [now.start, now.start])
        self._check_collisions(path, now)
        return path

    def to_pose(self, now: Circumstances, target: Array) -> Path:
        """A path to a pose of the tool in the map, shape (4, 4), on which all joints move evenly.

        Raises:
            RequestRefused: The pose is out of reach, or the arm would collide on all ways that were found.
        """
        aim = inverse(self.pose_base_in_map) @ target
        refused: RequestRefused | None = None
        found = solutions(self.chain, aim, now.start, self._home, self._noise)
        for _, configuration in zip(range(CANDIDATES), found, strict=False):
            try:
                return self.through(now, [configuration])
            except RequestRefused as error:
                refused = refused or error
        raise refused or RequestRefused(ArmResult.UNREACHABLE, self._unreached(target, aim))

    def _unreached(self, target: Array, aim: Array) -> str:
        """Why there is no way to a pose: it is proved to be out of reach, or was not found."""
        beyond = out_of_reach(self.chain, aim)
        if beyond > 0.0:
            return (
                f"the tool of {self._robot} cannot reach {_place(target)}, which is {beyond:.3f} m beyond the "
                f"stretched arm of {self.chain.reach:.3f} m"
            )
        return (
            f"the tool of {self._robot} cannot reach {_place(target)} in this orientation: no posture was found "
            f"from {STARTS + MORE_STARTS + 2} starts"
        )

    def straight(self, now: Circumstances, target: Array) -> Path:
        """The path on which the tool moves in a straight line to a pose in the map, shape (4, 4).

        Raises:
            RequestRefused: The tool cannot follow that line, or the arm would collide.
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
                    f"{length * (step - 1) / steps:.2f} m of {length:.2f} m: the arm does not reach farther, "
                    "or would have to turn over",
                )
            way.append(found)
        return self.through(now, way[1:])

    # ------------------------------------------------------------ checks

    def _check_limits(self, configuration: Array) -> None:
        limits = self.chain.limits
        for name, position, lower, upper in zip(
            self.chain.joints, configuration, limits.lower, limits.upper, strict=True
        ):
            if not lower <= position <= upper:
                raise RequestRefused(
                    ArmResult.OUT_OF_LIMITS,
                    f"{name} of {self._robot} goes from {lower:.3f} to {upper:.3f} rad, not to {position:.3f} rad",
                )

    def _check_collisions(self, path: Path, now: Circumstances) -> None:
        present = self._overlaps(now.start, now, self._own)
        allowed = {(it.link, it.other): it.depth + DEEPER for it in present}
        for index, place in enumerate(self._places(path)):
            own = self._own if index % OWN_CHECKS == 0 else ()
            for overlap in self._overlaps(path.at(place), now, own):
                if overlap.other in now.may_touch:
                    continue
                is_load = now.load is not None and overlap.link == now.load.name
                limit = CARRIED_OVERLAP if is_load else OVERLAP
                if overlap.depth > max(limit, allowed.get((overlap.link, overlap.other), 0.0)):
                    what = f"{overlap.link!r}, which it holds," if is_load else overlap.link
                    raise RequestRefused(
                        ArmResult.IN_COLLISION,
                        f"{self._robot} would collide {_along(place)}: {what} with {overlap.other!r}",
                    )

    def _places(self, path: Path) -> list[float]:
        """Where on a path collisions are looked for, its end first, which is what is wrong most often."""
        ways = np.abs(np.diff([path.at(knot) for knot in path.knots.tolist()], axis=0)).max(axis=1)
        count = max(1, math.ceil(float(ways.sum()) / CHECK_STEP))
        places: list[float] = np.linspace(0.0, 1.0, count + 1)[1:].tolist()
        return [places[-1], *places[:-1]]

    def _overlaps(
        self, configuration: Array, now: Circumstances, own: tuple[tuple[str, str], ...]
    ) -> tuple[Overlap, ...]:
        found = self._engine.arm_overlaps(self._robot, configuration, own, self._carried(configuration, now))
        return tuple(it for it in found if not self._is_grip(it, now))

    def _carried(self, configuration: Array, now: Circumstances) -> Carried | None:
        if now.load is None:
            return None
        pose = self.pose_base_in_map @ self.chain.tool_pose(configuration) @ now.load.pose_in_tool
        x, y, z = pose[:3, 3].tolist()
        return Carried(now.load.name, BodyState((x, y, z), quaternion_of(pose[:3, :3])))

    def _is_grip(self, overlap: Overlap, now: Circumstances) -> bool:
        """Whether it is of the gripper with what it holds."""
        return now.load is not None and overlap.link == now.load.name and overlap.other in self._hand


def check_count(robot: str, names: Sequence[str], positions: Sequence[float]) -> None:
    """Refuse positions that are not one for each joint, or no numbers."""
    if len(positions) != len(names) or not all(map(math.isfinite, positions)):
        raise RequestRefused(
            Result.OPERATION_FAILED,
            f"{robot} takes a finite position for each of {', '.join(names)}, not {list(positions)}",
        )


def _rotation(vector: Array) -> Array:
    """The (3, 3) matrix of a rotation vector [rad]."""
    angle = float(np.linalg.norm(vector))
    if angle == 0.0:
        return np.eye(3)
    x, y, z = (math.sin(angle / 2) * vector / angle).tolist()
    return rotation_matrix((math.cos(angle / 2), x, y, z))


def _along(place: float) -> str:
    return "at its goal" if place == 1.0 else f"after {place:.0%} of its way"


def _place(pose: Array) -> str:
    x, y, z = pose[:3, 3]
    return f"({x:.3f}, {y:.3f}, {z:.3f})"
